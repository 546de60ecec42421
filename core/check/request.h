#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome::check {

/// What `kinome check` is asked for.
struct Request {
  std::string plugin;  ///< name, CATEGORY/NAME, or the path of PLUGINS/CATEGORY/NAME.so
  std::map<std::string, std::string> parameters;  ///< of the plugin, as -D gives them
  std::vector<std::string> plugin_paths;          ///< more folders of plugins
  std::string isa;                                ///< "": the best that the processor has
  std::set<std::string> only;                     ///< names of checks; empty: all
  std::set<std::string> except;                   ///< names of checks that are left out
  std::string against;  ///< an integrator or emitter of the same light: a name, or XML
  double effort = 1;                              ///< of random samples, as a factor
  uint64_t seed = 0;
};

/// Checks a plugin, and prints what was found, one line a check. 0: nothing is wrong; 1: something
/// is. Throws Error where the request makes no sense.
KINOME_EXPORT int check_plugin(const Request& request);

}  // namespace kinome::check

/// The name by which the program finds check_plugin() in the library, which it opens only then.
extern "C" KINOME_EXPORT int kinome_check_plugin(const kinome::check::Request& request);
