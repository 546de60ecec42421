#pragma once

#include <string>

#include "kinome/integrator.h"

namespace kinome::viewer {

/// Returns the name of the plugin without its category, such as "path".
inline std::string name_of(const Integrator& integrator) {
  const std::string& plugin = integrator.plugin();
  return plugin.substr(plugin.find('/') + 1);
}

}  // namespace kinome::viewer
