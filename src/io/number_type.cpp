#include "io/number_type.h"

namespace pointbake {
namespace {

/// Calls body(T{}) with the type that `type` names.
template <class Body>
decltype(auto) with_type(NumberType type, Body&& body) {
    switch (type) {
        case NumberType::kInt8:
            return body(std::int8_t{});
        case NumberType::kUint8:
            return body(std::uint8_t{});
        case NumberType::kInt16:
            return body(std::int16_t{});
        case NumberType::kUint16:
            return body(std::uint16_t{});
        case NumberType::kInt32:
            return body(std::int32_t{});
        case NumberType::kUint32:
            return body(std::uint32_t{});
        case NumberType::kInt64:
            return body(std::int64_t{});
        case NumberType::kUint64:
            return body(std::uint64_t{});
        case NumberType::kFloat32:
            return body(float{});
        case NumberType::kFloat64:
            break;
    }
    return body(double{});
}

}  // namespace

std::size_t size_of(NumberType type) {
    return with_type(type, [](auto zero) { return sizeof(zero); });
}

double load_as_double(NumberType type, const std::byte* from, bool swap) {
    return with_type(type, [&](auto zero) {
        return static_cast<double>(load_value<decltype(zero)>(from, swap));
    });
}

void load_column(NumberType type, const std::byte* from, std::size_t stride, bool swap,
                 std::span<double> to) {
    // The switches over type and byte order are outside of the loop over rows.
    with_type(type, [&](auto zero) {
        using T = decltype(zero);
        if (swap)
            for (std::size_t i = 0; i < to.size(); ++i)
                to[i] = static_cast<double>(load_value<T>(from + i * stride, true));
        else
            for (std::size_t i = 0; i < to.size(); ++i)
                to[i] = static_cast<double>(load_value<T>(from + i * stride, false));
    });
}

}  // namespace pointbake
