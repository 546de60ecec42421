#include "plugin/plugin_check.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "plugin/property_types.h"

namespace kinome {
namespace {

using ObjectPointer = std::shared_ptr<Object>;

std::string plugin_title(const Properties& props) {
  return std::string(to_string(props.category())) + " '" + props.plugin_name() + "'";
}

/// Returns true for objects that are the values of named parameters.
bool is_by_name(Category category) {
  return category == Category::kTexture || category == Category::kVolume;
}

/// Returns true if the parameter's objects are matched by category, not by name.
bool is_by_category(const Parameter& row) {
  return row.type == ParameterType::kObject && !is_by_name(row.category) && !row.by_name;
}

bool has_pixels(const Properties& props) {
  return std::any_of(props.entries().begin(), props.entries().end(), [](const auto& entry) {
    return std::holds_alternative<std::shared_ptr<const Image>>(entry.second.value);
  });
}

/// Returns true if a value without a name, or with an unknown name, is probably meant for this
/// parameter. The parameter is then not reported as missing as well.
bool has_misnamed_value(const Parameter& row, const Properties& props,
                        const PluginDescriptor& plugin) {
  std::vector<std::string> known;
  for (const Parameter& other : plugin.parameters) known.emplace_back(other.name);
  return std::any_of(props.entries().begin(), props.entries().end(), [&](const auto& entry) {
    const auto& [name, value] = entry;
    if (find_row(plugin, name) || !accepts(row, value.value)) return false;
    const std::string nearest = name.starts_with("_arg_") ? "" : nearest_name(name, known);
    return nearest.empty() || nearest == row.name;
  });
}

/// Returns true if the plugin takes objects of this category, but only by name.
bool is_only_by_name(const PluginDescriptor& plugin, Category category) {
  bool has_name = false;
  for (const Parameter& row : plugin.parameters) {
    if (row.type != ParameterType::kObject || row.category != category) continue;
    if (!row.by_name) return false;
    has_name = true;
  }
  return has_name;
}

Error unknown_parameter(const Properties& props, const PluginDescriptor& plugin,
                        const std::string& name, const Properties::Entry& entry) {
  std::vector<std::string> known;
  std::string list;
  const bool is_object = std::holds_alternative<ObjectPointer>(entry.value);
  for (const Parameter& row : plugin.parameters) {
    if (is_by_category(row) || (is_object && !accepts(row, entry.value))) continue;
    known.push_back(row.name);
    list += (list.empty() ? "" : ", ") + known.back();
  }
  if (name.starts_with("_arg_")) {
    return Error(entry.where, describe(entry.value) + " of " + plugin_title(props) +
                                  " needs a name (" +
                                  (list.empty() ? "but it takes none" : "one of " + list) + ")");
  }
  const std::string nearest = nearest_name(name, known);
  std::string hint = list.empty() ? "it has none" : "it has " + list;
  if (!nearest.empty()) hint = "did you mean '" + nearest + "'?";
  return Error(entry.where,
               plugin_title(props) + " has no parameter '" + name + "' (" + hint + ")");
}

/// Counts nested objects that are matched by category. Their names are ignored.
class ObjectCounts {
 public:
  ObjectCounts(const Properties& props, const PluginDescriptor& plugin) : props_(props) {
    for (const Parameter& row : plugin.parameters) {
      if (!is_by_category(row)) continue;
      Count& count = counts_[static_cast<size_t>(row.category)];
      count.max += row.max_count;
      count.min += row.required ? 1 : 0;
    }
  }

  void add(Category category, const Location& where, std::vector<Error>& faults) {
    Count& count = counts_[static_cast<size_t>(category)];
    if (count.max == 0) {
      faults.emplace_back(where, plugin_title(props_) + " takes no " + to_string(category));
    } else if (++count.found > count.max) {
      faults.emplace_back(where, plugin_title(props_) + " takes at most " +
                                     std::to_string(count.max) + " " + to_string(category) +
                                     (count.max == 1 ? "" : "s"));
    }
  }

  void check_required(const Lost& lost, std::vector<Error>& faults) const {
    for (size_t i = 0; i < counts_.size(); ++i) {
      const auto category = static_cast<Category>(i);
      if (counts_[i].found >= counts_[i].min || lost.categories.count(category)) continue;
      faults.emplace_back(props_.where(), plugin_title(props_) + " needs " +
                                              (counts_[i].min == 1 ? "a nested " : "more nested ") +
                                              to_string(category));
    }
  }

 private:
  struct Count {
    int64_t min = 0;
    int64_t max = 0;
    int64_t found = 0;
  };
  const Properties& props_;
  std::array<Count, std::size(kCategories)> counts_;
};

void check_value(const Properties& props, const PluginDescriptor& plugin, const std::string& name,
                 const Properties::Entry& entry, std::vector<Error>& faults) {
  const Parameter* row = find_row(plugin, name);
  if (!row || is_by_category(*row)) {
    faults.push_back(unknown_parameter(props, plugin, name, entry));
  } else if (!accepts(*row, entry.value)) {
    faults.emplace_back(entry.where, "'" + name + "' must be " + describe(*row) + ", got " +
                                         describe(entry.value));
  }
}

}  // namespace

const Parameter* find_row(const PluginDescriptor& plugin, const std::string& name) {
  for (const Parameter& row : plugin.parameters) {
    if (name == row.name) return &row;
  }
  return nullptr;
}

std::vector<Error> check_parameters(const Properties& props, const PluginDescriptor& plugin,
                                    const Lost& lost) {
  std::vector<Error> faults;
  ObjectCounts counts(props, plugin);
  for (const auto& [name, entry] : props.entries()) {
    const auto* object = std::get_if<ObjectPointer>(&entry.value);
    if (!object) {
      check_value(props, plugin, name, entry, faults);
      continue;
    }
    const Category category = category_of(**object);
    const Parameter* const row = find_row(plugin, name);
    if (is_by_name(category) || (row && row->by_name) ||
        is_only_by_name(plugin, category)) {
      check_value(props, plugin, name, entry, faults);
    } else {
      counts.add(category, entry.where, faults);
    }
  }
  if (lost.anything) return faults;
  for (const Parameter& row : plugin.parameters) {
    if (!row.required || is_by_category(row) || props.has(row.name)) continue;
    if (row.by_name && lost.categories.count(row.category)) continue;
    // The pixels of an image may replace a required file.
    if (row.type == ParameterType::kFile && has_pixels(props)) continue;
    if (lost.names.count(row.name) || has_misnamed_value(row, props, plugin)) continue;
    faults.emplace_back(props.where(), plugin_title(props) + " needs parameter '" + row.name +
                                           "', " + describe(row));
  }
  counts.check_required(lost, faults);
  return faults;
}

std::vector<IgnoredEntry> take_ignored(const Properties& props, const PluginDescriptor& plugin) {
  std::vector<IgnoredEntry> ignored;
  for (const auto& [name, entry] : props.entries()) {
    const Parameter* const row = find_row(plugin, name);
    if (!row || !row->ignored) continue;
    entry.read = true;
    ignored.push_back({row, &entry});
  }
  return ignored;
}

void check_all_read(const Properties& props) {
  std::string list;
  const Location* first = nullptr;
  for (const auto& [name, entry] : props.entries()) {
    if (entry.read) continue;
    if (!first) first = &entry.where;
    list += (list.empty() ? "'" : ", '") + name + "'";
  }
  if (first) throw Error(*first, plugin_title(props) + " has unused parameters: " + list);
}

}  // namespace kinome
