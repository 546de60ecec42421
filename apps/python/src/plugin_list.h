#pragma once

#include <nanobind/nanobind.h>

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "kinome/plugin_registry.h"

namespace kinome::python {

namespace nb = nanobind;

/// The registry of the process, because plugins are never unloaded. Lock the mutex to use it.
struct Plugins {
  std::mutex mutex;
  std::vector<std::string> folders;
  std::unique_ptr<PluginRegistry> registry;
  PluginRegistry& get() {
    if (!registry) {
      registry = std::make_unique<PluginRegistry>(PluginRegistry::default_folders(folders));
    }
    return *registry;
  }
};
Plugins& plugins();

/// Releases the interpreter's lock and locks a mutex, for its lifetime.
class Turn {
 public:
  explicit Turn(std::mutex& mutex) : lock_(mutex) {}

 private:
  nb::gil_scoped_release release_;
  std::lock_guard<std::mutex> lock_;
};

/// Returns all plugins in the form of kinome.plugins().
nb::list list_plugins();
/// Returns the plugins' names by category, without opening their libraries.
std::map<std::string, std::vector<std::string>> plugin_names();
/// Returns eta and k of a conductor's `material`, as two tuples (r, g, b); None for other names.
nb::object measured_index_of(const std::string& material);

}  // namespace kinome::python
