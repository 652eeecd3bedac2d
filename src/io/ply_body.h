// The rows of a PLY file, decoded in blocks on several threads, the same way for text and binary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/ply_header.h"
#include "pointbake/context.h"

namespace pointbake {

/// One property over the rows of a block. Every PLY type fits a double exactly.
struct PlyColumn {
    std::vector<double> values;
    std::vector<std::size_t> ends;  ///< lists only: the values of row i end here

    std::span<const double> list(std::size_t row) const {
        const std::size_t begin = row == 0 ? 0 : ends[row - 1];
        return std::span<const double>(values).subspan(begin, ends[row] - begin);
    }
};

/// Consecutive rows of an element.
struct PlyBlock {
    std::size_t index = 0;  ///< among the element's blocks
    std::size_t first_row = 0;
    std::size_t num_rows = 0;
    std::vector<PlyColumn> columns;  ///< one per property asked for
};

/// Finds the elements' places on construction and checks that every promised row is there, so that
/// nothing needs to be allocated for rows that are not. Keeps views of its arguments, which must
/// outlive it.
class PlyBody {
 public:
    /// Looks at the first `num_elements` elements only. Throws Error{kInvalidInput} naming how many
    /// rows there are.
    PlyBody(std::span<const std::byte> bytes, const PlyHeader& header, std::size_t num_elements,
            const std::string& path, const Context& context);

    std::size_t num_blocks(std::size_t element) const;

    /// Calls body(block) for all blocks of the element, in any order, on several threads; blocks
    /// are cut the same way for any number of threads. Throws Error{kInvalidInput} with the line.
    void read(std::size_t element, std::span<const std::size_t> properties, const Context& context,
              const std::function<void(const PlyBlock&)>& body) const;

 private:
    /// Text is cut into chunks of lines; rows are lines that are neither blank nor comments.
    struct Chunk {
        std::size_t begin = 0, end = 0;
        std::size_t first_row = 0, num_rows = 0;  ///< counted over all elements
    };
    struct Place {
        std::size_t begin = 0;            ///< binary: byte; text: row counted over all elements
        std::vector<std::size_t> blocks;  ///< binary with lists: byte where each block begins
    };

    void cut_text(const Context& context);
    void place_text_rows();
    void place_binary_rows(std::size_t num_elements, const Context& context);
    std::size_t skip_list_rows(const PlyElement& element, Place& place,
                               const Context& context) const;
    void read_fixed(const PlyElement& element, const Place& place,
                    std::span<const std::size_t> properties, PlyBlock& block) const;
    void read_lists(const PlyElement& element, const Place& place,
                    std::span<const std::size_t> properties, PlyBlock& block) const;
    void read_text(const PlyElement& element, const Place& place, const Chunk& chunk,
                   std::span<const std::size_t> properties, PlyBlock& block) const;
    std::pair<std::size_t, std::size_t> text_chunks(std::size_t element) const;
    [[noreturn]] void fail_short(const PlyElement& element, std::uint64_t num_there) const;

    std::span<const std::byte> bytes_;
    const PlyHeader& header_;
    const std::string& path_;
    std::vector<Place> places_;
    std::vector<Chunk> chunks_;
};

}  // namespace pointbake
