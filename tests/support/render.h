#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinome/render.h"
#include "kinome/light_points.h"
#include "kinome/image.h"
#include "kinome/plugin_registry.h"
#include "kinome/render_context.h"
#include "kinome/scene_loader.h"
#include "support/statistics.h"

namespace kinome::test {

/// Returns the registry that a test program shares. It uses the plugins of the build tree.
PluginRegistry& registry();

/// Loads an object of a plugin from XML, such as `<bsdf type="phong"/>`. T is Bsdf, Emitter,
/// Texture, …. Throws Error as the loader does.
std::shared_ptr<Object> make_object(const std::string& xml);
template <class T>
std::shared_ptr<T> make(const std::string& xml) {
  return std::dynamic_pointer_cast<T>(make_object(xml));
}

/// Loads a scene from XML text (`<scene version="3.0.0">` … `</scene>`; the tags are optional).
std::unique_ptr<Scene> scene_from(const std::string& xml);
/// Renders sensor 0 with a seed, on `threads` threads. 0: all hardware threads.
Image render_scene(const Scene& scene, uint64_t seed = 0, unsigned threads = 0);
/// Returns the mean and the variance of the mean of each pixel and channel (R, G, B), in Image
/// order, over `renders` renders with the seeds `first_seed`, ….
std::vector<Estimate> estimate_pixels(const Scene& scene, int renders, uint64_t first_seed = 1);

/// Returns the same for sums over tiles of tile x tile pixels. Such sums are normally distributed
/// earlier than single pixels, whose bright samples are rare.
std::vector<Estimate> estimate_tiles(const Scene& scene, int renders, int tile,
                                     uint64_t first_seed = 1);

/// Returns the same for the difference a - b of renders with one seed, summed over tiles of tile x
/// tile pixels. If both scenes use the same positions in their pixels, the variance of these
/// cancels.
std::vector<Estimate> estimate_differences(const Scene& a, const Scene& b, int renders, int tile,
                                           uint64_t first_seed = 1);

/// Returns the light points of an emitter of distant light, which don't depend on the scene.
std::optional<LightPoints> light_points_of(const Emitter& emitter, uint32_t count, uint64_t seed);

/// A temporary folder, which the destructor removes.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  const std::string& folder() const { return folder_; }
  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& contents) const;

 private:
  std::string folder_;
};

/// A program run with a time limit: exit status (128 + signal if killed), stdout, stderr.
struct ProcessResult {
  int status = 0;
  std::string out;
  std::string err;
};
ProcessResult run_process(const std::vector<std::string>& arguments, double timeout_seconds = 1200);

}  // namespace kinome::test
