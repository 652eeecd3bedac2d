// All options of a command in one table, filled from the describe() of the options structs. The
// command line, the help, --config and --dump-options work on it; nothing is declared twice.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "option_value.h"

namespace pointbake::cli {

/// What an option is for: the headings of the help, in this order.
enum class OptionGroup {
    kReading,
    kCleaning,
    kGeometry,
    kTexture,
    kAtlas,
    kSampling,
    kOutput,
    kRunning
};

struct OptionEntry {
    std::string name;  ///< without dashes
    OptionGroup group;
    std::string help;
    std::string placeholder;     ///< empty: a flag
    std::string default_json;    ///< as JSON text
    bool shapes_result = false;  ///< whether the output depends on it: goes into the report
    std::string given;           ///< text it was last set from; empty = default
    std::function<void(std::string_view)> set;
    std::function<std::string()> json;
};

class OptionTable {
 public:
    /// Adds every option that Options describes. `options` must outlive the table. shapes_result:
    /// the output depends on them.
    template <class Options>
    void add(OptionGroup group, bool shapes_result, Options& options) {
        Options::describe([&](std::string_view name, auto member, std::string_view help) {
            using T = std::remove_cvref_t<decltype(options.*member)>;
            T& value = options.*member;
            entries_.push_back(
                {.name = std::string(name),
                 .group = group,
                 .help = std::string(help),
                 .placeholder = OptionValue<T>::placeholder(),
                 .default_json = OptionValue<T>::json(value),
                 .shapes_result = shapes_result,
                 .given = {},
                 .set = [&value](std::string_view text) { value = OptionValue<T>::parse(text); },
                 .json = [&value] { return OptionValue<T>::json(value); }});
        });
    }

    const std::vector<OptionEntry>& entries() const { return entries_; }

    /// Sets an option from text; errors name the option.
    void set(std::string_view name, std::string_view text);
    /// Sets what a JSON object says, except the options that were given already: flags win.
    void set_from_json(std::string_view json_text, std::string_view source);

    std::vector<std::string_view> names() const;
    /// All options as a JSON object; or only those that shape the result.
    std::string dump(bool only_result) const;

 private:
    OptionEntry* find(std::string_view name);

    std::vector<OptionEntry> entries_;
};

/// The name that is most like a mistyped one; empty if there are none.
std::string_view nearest_name(std::span<const std::string_view> known, std::string_view name);

}  // namespace pointbake::cli
