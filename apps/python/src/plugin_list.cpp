#include "plugin_list.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "kinome/measured_indices.h"

namespace kinome::python {
namespace {

struct FoundPlugin {
  Category category;
  std::string name;
  const PluginDescriptor* plugin;  ///< in the plugin's library, which is never unloaded
};

/// Waits without the interpreter's lock, because another thread may be loading a scene. So it can't
/// create Python objects.
std::vector<FoundPlugin> find_plugins() {
  const Turn turn(plugins().mutex);
  PluginRegistry& registry = plugins().get();
  std::vector<FoundPlugin> all;
  for (const Category category : kCategories) {
    for (const std::string& name : registry.names(category)) {
      all.push_back({category, name, &registry.find(category, name)});
    }
  }
  return all;
}

}  // namespace

Plugins& plugins() {
  static Plugins* const all = new Plugins;
  return *all;
}

nb::list list_plugins() {
  nb::list all;
  for (const FoundPlugin& found : find_plugins()) {
    nb::list rows;
    for (const Parameter& p : found.plugin->parameters) {
      nb::dict row;
      row["name"] = p.name;
      row["type"] = p.type == ParameterType::kObject ? to_string(p.category) : to_string(p.type);
      row["default"] =
          p.default_value ? nb::object(nb::str(p.default_value)) : nb::object(nb::none());
      row["doc"] = p.doc;
      row["required"] = p.required;
      row["ignored"] = p.ignored;
      row["choices"] = std::vector<std::string>(p.choices.begin(), p.choices.end());
      rows.append(row);
    }
    nb::dict one;
    one["category"] = to_string(found.category);
    one["name"] = found.name;
    one["doc"] = found.plugin->doc;
    one["parameters"] = rows;
    all.append(one);
  }
  return all;
}

std::map<std::string, std::vector<std::string>> plugin_names() {
  const Turn turn(plugins().mutex);
  std::map<std::string, std::vector<std::string>> all;
  for (const Category category : kCategories) {
    all[to_string(category)] = plugins().get().names(category);
  }
  return all;
}

nb::object measured_index_of(const std::string& material) {
  const MeasuredIndex* const found = measured_index(material);
  if (!found) return nb::none();
  const auto triple = [](const Rgb& color) { return nb::make_tuple(color.r, color.g, color.b); };
  return nb::make_tuple(triple(found->eta), triple(found->k));
}

}  // namespace kinome::python
