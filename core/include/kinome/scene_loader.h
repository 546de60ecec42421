#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kinome/plugin_registry.h"
#include "kinome/scene.h"

namespace kinome {

struct LoadOptions {
  std::map<std::string, std::string> defines;  ///< -D key=value
  std::vector<std::string> search_paths;       ///< -a
  unsigned threads = 0;                        ///< for the acceleration structure; 0: one per core
  /// What is Mitsuba's and not here is left out of the scene, and listed in RenderStats::left_out;
  /// else it is a mistake.
  bool lenient = false;
};

/// Loads a scene in Mitsuba's XML language. Throws Errors: all mistakes in it and in the files that
/// it names, each with file, line and column, by their places in the scene; an Error where the
/// scene file can't be read.
KINOME_EXPORT std::unique_ptr<Scene> load_scene(const std::string& path, const LoadOptions& options,
                                                PluginRegistry& registry,
                                                RenderStats* stats = nullptr);
/// The same from text; `name` stands for the file in messages.
KINOME_EXPORT std::unique_ptr<Scene> load_scene_from_string(const std::string& xml,
                                                            const std::string& name,
                                                            const LoadOptions& options,
                                                            PluginRegistry& registry,
                                                            RenderStats* stats = nullptr);
/// All mistakes, as load_scene() finds them; nothing is made ready to render. No errors are thrown.
KINOME_EXPORT std::vector<Error> check_scene(const std::string& path, const LoadOptions& options,
                                             PluginRegistry& registry);
/// One object with its children, such as `<bsdf type="phong"/>`. Its version may be left out.
KINOME_EXPORT std::shared_ptr<Object> load_object_from_string(const std::string& xml,
                                                              const std::string& name,
                                                              const LoadOptions& options,
                                                              PluginRegistry& registry);

}  // namespace kinome
