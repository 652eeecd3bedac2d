#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <sstream>

#include "pointbake/write.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::decode_png;
using fixtures::Folder;
using fixtures::patch_grid;
using fixtures::read_text;
using fixtures::tetrahedron;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// What an OBJ says, in the simplest words.
struct ObjContents {
    std::vector<std::vector<double>> v, vt, vn;
    struct Corner {
        std::size_t v = 0, vt = 0, vn = 0;
    };
    std::vector<std::array<Corner, 3>> faces;
    std::vector<std::string> face_materials;
    std::map<std::string, std::map<std::string, std::string>> materials;
};

void read_mtl(const std::filesystem::path& path, ObjContents& obj) {
    std::istringstream lines(read_text(path));
    std::string line, current;
    while (std::getline(lines, line)) {
        const std::size_t blank = line.find(' ');
        if (line.starts_with("newmtl ")) current = line.substr(7);
        obj.materials[current][line.substr(0, blank)] = line.substr(blank + 1);
    }
}

ObjContents read_obj(const std::filesystem::path& path) {
    ObjContents obj;
    std::istringstream lines(read_text(path));
    std::string line, material;
    while (std::getline(lines, line)) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v" || word == "vt" || word == "vn") {
            auto& to = word == "v" ? obj.v : (word == "vt" ? obj.vt : obj.vn);
            to.emplace_back();
            while (words >> word) to.back().push_back(std::stod(word));
        } else if (word == "usemtl") {
            words >> material;
        } else if (word == "mtllib") {
            read_mtl(path.parent_path() / line.substr(7), obj);
        } else if (word == "f") {
            auto& face = obj.faces.emplace_back();
            obj.face_materials.push_back(material);
            for (auto& c : face) {
                words >> word;
                char* end = word.data();
                c.v = std::strtoul(end, &end, 10);
                if (*end == '/' && end[1] != '/') c.vt = std::strtoul(end + 1, &end, 10);
                if (*end == '/') c.vn = std::strtoul(end + (end[1] == '/' ? 2 : 1), &end, 10);
            }
        }
    }
    return obj;
}

TEST(Obj, HoldsTheModelInFullDouble) {
    const Folder folder;
    const TexturedMesh model = patch_grid(6, 2, {500000.123, 5000000.456, 1.0 / 3.0}, 0.1);
    const WriteReport report = write_model(model, folder / "a b.obj");
    EXPECT_THAT(folder.names(), ElementsAre("a b.mtl", "a b.obj", "a b_0.png", "a b_1.png"));
    EXPECT_EQ(report.global_shift, Vec3d{});
    const ObjContents obj = read_obj(folder / "a b.obj");
    ASSERT_EQ(obj.v.size(), model.mesh.positions.size());
    for (std::size_t i = 0; i < obj.v.size(); ++i)
        EXPECT_THAT(obj.v[i], ElementsAre(model.mesh.positions[i].x, model.mesh.positions[i].y,
                                          model.mesh.positions[i].z));
    ASSERT_EQ(obj.faces.size(), model.mesh.triangles.size());
    EXPECT_EQ(obj.vt.size(), report.num_vertices);
    std::size_t f = 0;
    for (Index page = 0; page < 2; ++page) {
        for (std::size_t t = 0; t < obj.faces.size(); ++t) {
            if (model.triangle_materials[t] != page) continue;
            EXPECT_EQ(obj.face_materials[f], page == 0 ? "page_0" : "page_1");
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_EQ(obj.faces[f][k].v, model.mesh.triangles[t][k] + 1);
                const auto& vt = obj.vt[obj.faces[f][k].vt - 1];
                EXPECT_NEAR(vt[0], model.mesh.uvs[t][k].x, 1e-7);
                EXPECT_NEAR(1.0 - vt[1], model.mesh.uvs[t][k].y, 1e-7);
            }
            ++f;
        }
    }
    EXPECT_EQ(obj.materials.at("page_1").at("map_Kd"), "a b_1.png");
    const std::string png = read_text(folder / "a b_1.png");
    EXPECT_EQ(decode_png(png.data(), png.size()).pixels, model.images[1].pixels);
    std::uint64_t num_bytes = 0;
    for (const auto& path : report.files) num_bytes += std::filesystem::file_size(path);
    EXPECT_EQ(report.num_bytes, num_bytes);
    EXPECT_EQ(report.num_draw_calls, 2U);
}

TEST(Obj, BareGeometryAndVertexColours) {
    const Folder folder;
    TexturedMesh model = tetrahedron();
    write_model(model, folder / "a.obj");
    EXPECT_EQ(read_obj(folder / "a.obj").v[0].size(), 3U);
    EXPECT_THAT(read_text(folder / "a.obj"), HasSubstr("f 1 3 2\n"));
    model.mesh.colors.assign(4, Rgb16{65535, 257 * 51, 0});
    write_model(model, folder / "a.obj");
    EXPECT_THAT(read_obj(folder / "a.obj").v[1], ElementsAre(1, 0, 0, 1.0, 0.2, 0));
}

TEST(Obj, VertexColoursShowWhereAnImageCannot) {
    const Folder folder;
    TexturedMesh model = patch_grid(2, 1);
    model.mesh.colors.assign(model.mesh.positions.size(), Rgb16{65535, 0, 0});
    write_model(model, folder / "a.obj");
    EXPECT_EQ(read_obj(folder / "a.obj").v[0].size(), 3U);
    model.mesh.uvs.clear();
    write_model(model, folder / "b.obj");
    EXPECT_EQ(read_obj(folder / "b.obj").v[0].size(), 6U);
    EXPECT_FALSE(std::filesystem::exists(folder / "b.png"));
}

TEST(Obj, NormalsAreThereWhenLit) {
    const Folder folder;
    TexturedMesh model = patch_grid(2, 1);
    model.mesh.normals.assign(model.mesh.positions.size(), Vec3f{0, 0, 1});
    write_model(model, folder / "a.obj");
    EXPECT_TRUE(read_obj(folder / "a.obj").vn.empty());
    write_model(model, folder / "a.obj", {.shading = Shading::kLit});
    const ObjContents obj = read_obj(folder / "a.obj");
    EXPECT_EQ(obj.vn.size(), model.mesh.positions.size());
    EXPECT_EQ(obj.faces[3][1].vn, obj.faces[3][1].v);
    EXPECT_GT(obj.faces[3][1].vt, 0U);
}

TEST(Obj, MaterialNamesAreMadeUnique) {
    const Folder folder;
    TexturedMesh model = patch_grid(2, 2);
    for (Material& m : model.materials) m.name = "my page";
    write_model(model, folder / "a.obj");
    const ObjContents obj = read_obj(folder / "a.obj");
    EXPECT_EQ(obj.materials.count("my_page"), 1U);
    EXPECT_EQ(obj.materials.count("my_page_1"), 1U);
}

/// The bytes behind a PLY's header.
struct PlyContents {
    std::string header, body;
    explicit PlyContents(const std::filesystem::path& path) {
        const std::string text = read_text(path);
        const std::size_t end = text.find("end_header\n") + 11;
        header = text.substr(0, end);
        body = text.substr(end);
    }
    template <class T>
    T at(std::size_t offset) const {
        T value;
        std::memcpy(&value, body.data() + offset, sizeof value);
        return value;
    }
};

TEST(Ply, HoldsTextureCoordinatesPerFace) {
    const Folder folder;
    const TexturedMesh model = patch_grid(4, 2, {5e5, 5e6, 0}, 0.1);
    const WriteReport report = write_model(model, folder / "a.ply");
    EXPECT_EQ(report.num_draw_calls, 2U);
    EXPECT_EQ(report.num_vertices, model.mesh.positions.size());
    const PlyContents ply(folder / "a.ply");
    EXPECT_THAT(ply.header,
                HasSubstr("comment TextureFile a_0.png\ncomment TextureFile a_1.png\n"));
    EXPECT_THAT(ply.header, HasSubstr("element vertex 25\nproperty double x\nproperty double y\n"));
    EXPECT_THAT(ply.header,
                HasSubstr("element face 32\nproperty list uchar int vertex_indices\nproperty list "
                          "uchar float texcoord\nproperty int texnumber\nend_header\n"));
    const std::size_t face = 1 + 12 + 1 + 24 + 4;
    ASSERT_EQ(ply.body.size(), 25 * 24 + 32 * face);
    for (std::size_t v = 0; v < 25; ++v) EXPECT_EQ(ply.at<Vec3d>(24 * v), model.mesh.positions[v]);
    for (std::size_t t = 0; t < 32; ++t) {
        const std::size_t at = 25 * 24 + t * face;
        EXPECT_EQ(ply.at<std::uint8_t>(at), 3);
        EXPECT_EQ((ply.at<std::array<Index, 3>>(at + 1)), model.mesh.triangles[t]);
        EXPECT_EQ(ply.at<std::uint8_t>(at + 13), 6);
        EXPECT_EQ(ply.at<float>(at + 14), model.mesh.uvs[t][0].x);
        EXPECT_NEAR(ply.at<float>(at + 18), 1.0F - model.mesh.uvs[t][0].y, 1e-7);
        EXPECT_EQ(ply.at<std::int32_t>(at + 38), static_cast<int>(model.triangle_materials[t]));
    }
}

TEST(Ply, PlainMeshesHaveColoursAndFloatsWhereTheySuffice) {
    const Folder folder;
    TexturedMesh model = tetrahedron();
    model.mesh.colors.assign(4, Rgb16{257 * 7, 257 * 8, 257 * 9});
    write_model(model, folder / "a.ply");
    const PlyContents ply(folder / "a.ply");
    EXPECT_THAT(ply.header, HasSubstr("property float z\nproperty uchar red\n"));
    EXPECT_THAT(ply.header, Not(HasSubstr("texcoord")));
    ASSERT_EQ(ply.body.size(), 4 * 15 + 4 * 13U);
    EXPECT_EQ((ply.at<std::array<std::uint8_t, 3>>(12)), (std::array<std::uint8_t, 3>{7, 8, 9}));
    model.mesh.colors[2].g = 1;  // needs 16 bits
    write_model(model, folder / "a.ply");
    EXPECT_THAT(PlyContents(folder / "a.ply").header, HasSubstr("property ushort green"));
}

TEST(Ply, OtherFormatsTellTheFrameInAComment) {
    const Folder folder;
    TexturedMesh model = tetrahedron();
    model.frame = {.up = UpAxis::kZ,
                   .metres_per_unit = 0.3048,
                   .unit = "foot",
                   .height_unit = {},
                   .crs = {.name = "Site\nelement", .epsg = 2994}};
    write_model(model, folder / "a.ply");
    EXPECT_THAT(PlyContents(folder / "a.ply").header,
                HasSubstr("\ncomment unit 0.3048 m, z up, Site element, EPSG:2994\n"));
    write_model(model, folder / "a.obj");
    EXPECT_THAT(fixtures::read_text(folder / "a.obj"),
                HasSubstr("\n# unit 0.3048 m, z up, Site element, EPSG:2994\n"));
    write_model(model, folder / "a.obj", {.up = UpAxis::kX, .scale = 2.0});
    EXPECT_THAT(fixtures::read_text(folder / "a.obj"), HasSubstr("\n# unit 2 m, x up, Site"));
}

TEST(Ply, OtherFormatsSayThatTheyHaveNoNodeTransform) {
    const Folder folder;
    std::vector<std::string> lines;
    const Context context{.log = [&](LogLevel level, std::string_view line) {
        if (level == LogLevel::kWarning) lines.emplace_back(line);
    }};
    write_model(tetrahedron(), folder / "a.ply", {.up = UpAxis::kZ}, context);
    EXPECT_THAT(lines, ElementsAre(HasSubstr("--up")));
}

}  // namespace
}  // namespace pointbake
