#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome::check {

/// Options of `kinome check`.
struct Request {
  std::string plugin;  ///< name, CATEGORY/NAME, or the path of PLUGINS/CATEGORY/NAME.so
  std::map<std::string, std::string> parameters;  ///< the plugin's parameters, as given by -D
  std::vector<std::string> plugin_paths;          ///< additional plugin folders
  std::string isa;                                ///< "": the best one of the processor
  std::set<std::string> only;                     ///< names of checks; empty: all
  std::set<std::string> except;                   ///< names of excluded checks
  std::string against;  ///< an integrator or emitter for the same light: a name, or XML
  double effort = 1;    ///< factor of the number of random samples
  uint64_t seed = 0;
};

/// Checks a plugin, and prints one line per check. Returns 0 if all checks passed, otherwise 1.
/// Throws Error if the request is invalid.
KINOME_EXPORT int check_plugin(const Request& request);

}  // namespace kinome::check

/// Calls check_plugin(). The program looks this name up in the library, which it loads on demand.
extern "C" KINOME_EXPORT int kinome_check_plugin(const kinome::check::Request& request);
