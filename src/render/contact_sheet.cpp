// Pictures side by side.
#include <algorithm>

#include "core/message.h"
#include "render/canvas.h"

namespace pointbake {

Image contact_sheet(const std::vector<Image>& pictures, int columns) {
    if (columns < 1 || pictures.empty())
        fail(ErrorCode::kInvalidOption, "a contact sheet of {} pictures in {} columns",
             pictures.size(), columns);
    int cell_width = 0, cell_height = 0;
    for (const Image& picture : pictures) {
        if (picture.num_channels != 3)
            fail(ErrorCode::kUnsupported, "a contact sheet takes RGB pictures, not {} channels",
                 picture.num_channels);
        cell_width = std::max(cell_width, picture.width);
        cell_height = std::max(cell_height, picture.height);
    }
    const int count = static_cast<int>(pictures.size());
    const int rows = (count + columns - 1) / columns;
    Image sheet{cell_width * std::min(columns, count), cell_height * rows, 3, {}};
    sheet.pixels.resize(3 * sheet.num_texels());
    for (std::size_t k = 0; k < sheet.pixels.size(); ++k)
        sheet.pixels[k] = render::kBackground[k % 3];
    for (int n = 0; n < count; ++n) {
        const Image& picture = pictures[static_cast<std::size_t>(n)];
        // Smaller pictures sit in the middle of their cell.
        const int x = n % columns * cell_width + (cell_width - picture.width) / 2;
        const int y = n / columns * cell_height + (cell_height - picture.height) / 2;
        for (int row = 0; row < picture.height; ++row)
            std::copy_n(picture.pixels.begin() + std::ptrdiff_t{3} * row * picture.width,
                        3 * picture.width,
                        sheet.pixels.begin() + 3 * (std::ptrdiff_t{y + row} * sheet.width + x));
    }
    return sheet;
}

}  // namespace pointbake
