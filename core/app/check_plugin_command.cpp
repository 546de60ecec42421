// `kinome check`: hands the request to the library that checks plugins, which nothing else needs.

#include <dlfcn.h>

#include "check/request.h"
#include "commands.h"
#include "crash.h"
#include "kinome/error.h"

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
  // Found as the core's library is. Never closed: see PluginRegistry.
  void* const library = dlopen("libkinome_check.so", RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    throw Error(std::string("the library of checks, which comes with what plugins are built with, "
                            "can't be loaded: ") +
                dlerror());
  }
  const auto check_plugin =
      reinterpret_cast<decltype(&kinome_check_plugin)>(dlsym(library, "kinome_check_plugin"));
  if (!check_plugin) throw Error("the library of checks is of another version");
  return check_plugin(request);
}

}  // namespace kinome::app
