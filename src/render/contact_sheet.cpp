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
    const int num_channels = pictures[0].num_channels;
    for (const Image& picture : pictures) {
        if ((num_channels != 3 && num_channels != 4) || picture.num_channels != num_channels)
            fail(ErrorCode::kUnsupported, "a contact sheet takes RGB or RGBA pictures of one kind");
        cell_width = std::max(cell_width, picture.width);
        cell_height = std::max(cell_height, picture.height);
    }
    const int count = static_cast<int>(pictures.size());
    const int rows = (count + columns - 1) / columns;
    Image sheet{cell_width * std::min(columns, count), cell_height * rows, num_channels, {}};
    const auto channels = static_cast<std::size_t>(num_channels);
    sheet.pixels.resize(channels * sheet.num_texels());
    for (std::size_t k = 0; k < sheet.pixels.size(); ++k)
        sheet.pixels[k] = k % channels == 3 ? std::uint8_t{0} : render::kBackground[k % channels];
    for (int n = 0; n < count; ++n) {
        const Image& picture = pictures[static_cast<std::size_t>(n)];
        // Smaller pictures sit in the middle of their cell.
        const int x = n % columns * cell_width + (cell_width - picture.width) / 2;
        const int y = n / columns * cell_height + (cell_height - picture.height) / 2;
        for (int row = 0; row < picture.height; ++row)
            std::copy_n(
                picture.pixels.begin() + std::ptrdiff_t{num_channels} * row * picture.width,
                num_channels * picture.width,
                sheet.pixels.begin() + num_channels * (std::ptrdiff_t{y + row} * sheet.width + x));
    }
    return sheet;
}

}  // namespace pointbake
