#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kinome/film.h"
#include "kinome/plugin_registry.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/scene.h"

namespace kinome {

/// Changes to a scene that is rendered for a denoiser. Films get a box filter of one pixel, so that
/// the noise of pixels is independent. The scene's integrator is nested in `aov`, which adds the
/// channels kAlbedo + ".R", ".G", ".B" and kNormal + ".X", ".Y", ".Z". Channels of the scene's own
/// integrator have the prefix kNested + ".".
struct DenoisingSetup {
  static constexpr const char* kNested = "_noisy";
  static constexpr const char* kAlbedo = "_guide_albedo";
  static constexpr const char* kNormal = "_guide_normal";
  /// Filters that the scene gives to its films. Set by the loader.
  std::map<const Film*, std::shared_ptr<const ReconstructionFilter>> filters;
};

/// Options for loading a scene.
struct LoadOptions {
  std::map<std::string, std::string> defines;  ///< -D key=value
  std::vector<std::string> search_paths;       ///< -a
  /// Threads that read files and build the acceleration structure; 0: one per core.
  unsigned threads = 0;
  /// Skips features of Mitsuba that Kinome lacks and lists them in RenderStats::left_out. Otherwise
  /// they are errors.
  bool lenient = false;
  /// Prepares the scene for denoising, unless nullptr.
  std::shared_ptr<DenoisingSetup> denoising = nullptr;
};

/// Loads a scene in Mitsuba's XML format. Throws Errors with all errors in the scene and the files
/// that it names, each with file, line and column, in scene order. Throws Error if the scene file
/// can't be read.
KINOME_EXPORT std::unique_ptr<Scene> load_scene(const std::string& path, const LoadOptions& options,
                                                PluginRegistry& registry,
                                                RenderStats* stats = nullptr);
/// Loads a scene from text; `name` is its file name in messages.
KINOME_EXPORT std::unique_ptr<Scene> load_scene_from_string(const std::string& xml,
                                                            const std::string& name,
                                                            const LoadOptions& options,
                                                            PluginRegistry& registry,
                                                            RenderStats* stats = nullptr);
/// Returns all errors that load_scene() would throw, without preparing the scene for rendering.
/// Throws nothing.
KINOME_EXPORT std::vector<Error> check_scene(const std::string& path, const LoadOptions& options,
                                             PluginRegistry& registry);
/// Loads one object with its children, such as `<bsdf type="phong"/>`. The version attribute is
/// optional.
KINOME_EXPORT std::shared_ptr<Object> load_object_from_string(const std::string& xml,
                                                              const std::string& name,
                                                              const LoadOptions& options,
                                                              PluginRegistry& registry);

}  // namespace kinome
