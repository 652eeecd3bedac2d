#include "io/ply_points.h"

#include "io/ply_splats.h"
#include "io/splats.h"

namespace pointbake {
namespace {

/// The scalar properties of an element, as columns of a table.
struct ScalarProperties {
    std::vector<TableColumn> columns;
    std::vector<std::size_t> properties;  ///< of each column
    std::string lists;                    ///< names of those that are none
};

ScalarProperties scalar_properties(const PlyElement& element) {
    ScalarProperties found;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& p = element.properties[i];
        if (p.is_list()) {
            found.lists += (found.lists.empty() ? "" : ", ") + p.name;
            continue;
        }
        found.columns.push_back({p.name, p.type});
        found.properties.push_back(i);
    }
    return found;
}

}  // namespace

PointRows read_ply_points(const PlyBody& body, const PlyHeader& header, std::size_t element,
                          const std::string& path, const Context& context) {
    if (has_packed_splats(header.elements[element]))
        return read_packed_splats(body, header, element, path, context);
    ScalarProperties scalars = scalar_properties(header.elements[element]);
    PointTable table(std::move(scalars.columns), path, "element 'vertex' has no scalar property");
    table.allocate(header.elements[element].count);
    std::vector<std::size_t> properties;
    for (const std::size_t column : table.wanted())
        properties.push_back(scalars.properties[column]);
    body.read(element, properties, context, [&](const PlyBlock& block) {
        TableBlock columns{block.first_row, block.num_rows, {}};
        for (const PlyColumn& column : block.columns) columns.columns.emplace_back(column.values);
        table.store(columns);
    });
    PointRows rows = table.finish(context);
    if (SplatShapes shapes; take_shapes(rows.cloud, shapes, context))
        make_surfels(rows, shapes, context);
    if (!scalars.lists.empty())
        rows.notes.push_back("list properties of 'vertex' ignored: " + scalars.lists);
    return rows;
}

}  // namespace pointbake
