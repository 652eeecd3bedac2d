#include "option_table.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace pointbake::cli {

using Json = nlohmann::ordered_json;

namespace {

/// Number of letters to insert, drop, replace or swap to turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before_previous, previous(b.size() + 1), current(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        current[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            current[j] = std::min({previous[j] + 1, current[j - 1] + 1,
                                   previous[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
            const bool is_swap = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (is_swap) current[j] = std::min(current[j], before_previous[j - 2] + 1);
        }
        before_previous = previous;
        previous = current;
    }
    return previous[b.size()];
}

}  // namespace

OptionEntry* OptionTable::find(std::string_view name) {
    const auto entry = std::ranges::find(entries_, name, &OptionEntry::name);
    return entry == entries_.end() ? nullptr : &*entry;
}

void OptionTable::set(std::string_view name, std::string_view text) {
    OptionEntry* const entry = find(name);
    if (!entry) fail(ErrorCode::kInvalidOption, "unknown option --{}", name);
    try {
        entry->set(text);
    } catch (const Error& error) {
        fail(error.code(), "--{}: {}", name, error.what());
    }
    entry->given = text;
}

void OptionTable::set_from_json(std::string_view json_text, std::string_view source) {
    const Json config = Json::parse(json_text, nullptr, false);
    if (!config.is_object())
        fail(ErrorCode::kInvalidOption,
             "{} is not a JSON object like {{\"triangles\": 5000}} (see --dump-options)", source);
    for (const auto& [name, value] : config.items()) {
        OptionEntry* const entry = find(name);
        if (!entry)
            fail(ErrorCode::kInvalidOption, "{}: unknown option '{}'; nearest: '{}'", source, name,
                 nearest_name(names(), name));
        if (!entry->given.empty() || value.is_null()) continue;
        if (!value.is_primitive())
            fail(ErrorCode::kInvalidOption, "{}: '{}' must be a number, a text or a truth value",
                 source, name);
        try {
            set(name, value.is_string() ? value.get<std::string>() : value.dump());
        } catch (const Error& error) {
            fail(error.code(), "{}: {}", source, error.what());
        }
    }
}

std::string OptionTable::dump(bool only_result) const {
    Json object = Json::object();
    for (const OptionEntry& entry : entries_) {
        if (only_result && !entry.shapes_result) continue;
        object[entry.name] = Json::parse(entry.json());
    }
    return object.dump(2);
}

std::vector<std::string_view> OptionTable::names() const {
    std::vector<std::string_view> names;
    for (const OptionEntry& entry : entries_) names.push_back(entry.name);
    return names;
}

std::string_view nearest_name(std::span<const std::string_view> known, std::string_view name) {
    std::string_view best;
    std::size_t best_distance = ~std::size_t{0};
    for (const std::string_view candidate : known) {
        // A word that was only begun, or is a part of a name, is nearer than its length tells.
        const bool is_part = name.size() >= 3 && candidate.find(name) != std::string_view::npos;
        const std::size_t distance = is_part ? 1 : edit_distance(name, candidate);
        if (distance < best_distance) {
            best = candidate;
            best_distance = distance;
        }
    }
    return best;
}

}  // namespace pointbake::cli
