#pragma once

#include <string>
#include <vector>

#include "kinome/plugin_registry.h"
#include "kinome/scene_loader.h"
#include "probe.h"

namespace kinome::test {

/// Returns a registry with the build's plugins and those of this folder.
inline PluginRegistry& probe_registry() {
  static PluginRegistry registry({KINOME_UNIT_PLUGINS, KINOME_TEST_PLUGINS});
  return registry;
}

/// Returns a probe with these children.
inline std::shared_ptr<Probe> probe(const std::string& children, const LoadOptions& options = {},
                                    const std::string& version = "3.0.0") {
  const std::string xml =
      "<texture version=\"" + version + "\" type=\"probe\">" + children + "</texture>";
  return std::dynamic_pointer_cast<Probe>(
      load_object_from_string(xml, "probe.xml", options, probe_registry()));
}

/// Returns what() of the Error that a function throws, or "no error".
template <class Function>
std::string error_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

/// Returns what() of each Error that a function throws.
template <class Function>
std::vector<std::string> errors_of(const Function& function) {
  std::vector<std::string> found;
  try {
    function();
  } catch (const Errors& errors) {
    for (const Error& error : errors.all()) found.emplace_back(error.what());
  }
  return found;
}

}  // namespace kinome::test
