// What readers of text do about rows that are no numbers, and about sensors.
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "io/point_table.h"
#include "io/text_rows.h"

namespace pointbake {

/// The whole text of a file, for messages about places in it.
struct TextSource {
    std::string name;
    std::string_view text;
    char line_end = '\n';

    /// "name:line" of what `part`, a view into the text, begins with.
    std::string place(std::string_view part) const;
};

/// Collects bad rows from several threads.
class BadRows {
 public:
    /// `base`: the row that the block's first row of all is among all rows of the file.
    void add(const TextBlock& block, std::size_t base = 0);

    /// Drops them, with a note. Throws Error{kInvalidInput} naming the first if they are more
    /// than half.
    void drop_from(PointRows& rows, const TextSource& source, std::size_t num_columns);

 private:
    struct Entry {
        std::size_t row;
        std::string_view line;
        std::string_view problem;
    };
    std::mutex mutex_;
    std::vector<Entry> entries_;
};

/// Directions from the points [begin, end) to the sensor that saw them; makes room for them.
void face_sensor(PointRows& rows, std::size_t begin, std::size_t end, Vec3d sensor);

}  // namespace pointbake
