// The compressed points of a LAZ file.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include "io/las_header.h"
#include "pointbake/context.h"

namespace pointbake {

struct LazSink {
    /// Called once, when the file can hold the points that its header promises.
    std::function<void()> allocate;
    /// Consecutive records as an uncompressed file has them; called on several threads.
    std::function<void(std::size_t first_row, std::size_t num_rows, const std::byte* records)>
        store;
};

/// Unpacks all points. Without a usable table of chunks they are found one after the other;
/// returns a note about that, else nothing. Throws Error{kInvalidInput, kUnsupported, kLimit}.
std::string unpack_laz(std::span<const std::byte> bytes, const LasHeader& header,
                       const std::string& name, const LazSink& sink, const Context& context);

}  // namespace pointbake
