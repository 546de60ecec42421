// `kinome check`: loads the library that checks plugins, and forwards the request to it.

#include <dlfcn.h>

#include "kit/request.h"
#include "commands.h"
#include "crash.h"
#include "kinome/error.h"
#include "own_library.h"

namespace kinome::app {

int check_plugin_command(const Options& options) {
  set_activity("checking a plugin");
  warn_of_missing_folders(options);
  check::Request request;
  request.plugin = options.plugin_name;
  request.parameters = options.defines;
  request.plugin_paths = options.plugin_paths;
  request.isa = options.isa;
  request.only = {options.only.begin(), options.only.end()};
  request.except = {options.except.begin(), options.except.end()};
  request.against = options.against;
  request.effort = options.effort;
  request.seed = options.seed;
  // Found on the same path as the core's library. Never closed: see PluginRegistry.
  void* const library = open_own_library("libkinome_kit.so", RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    throw Error(std::string("can't load libkinome_kit.so, which is installed with the headers "
                            "for plugins: ") +
                dlerror());
  }
  const auto check_plugin =
      reinterpret_cast<decltype(&kinome_check_plugin)>(dlsym(library, "kinome_check_plugin"));
  if (!check_plugin) throw Error("libkinome_kit.so is from another version of kinome");
  return check_plugin(request);
}

}  // namespace kinome::app
