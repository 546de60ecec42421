#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "kinome/plugin_registry.h"
#include "kinome/render_context.h"
#include "kinome/scene_loader.h"
#include "support/statistics.h"

namespace kinome::test {

/// One registry for a test program, over the build tree's plugins.
PluginRegistry& registry();

/// An object of a plugin from XML, such as `<bsdf type="phong"/>`: T is Bsdf, Emitter, Texture, ….
/// Throws Error as the loader does.
std::shared_ptr<Object> make_object(const std::string& xml);
template <class T>
std::shared_ptr<T> make(const std::string& xml) {
  return std::dynamic_pointer_cast<T>(make_object(xml));
}

/// A scene from XML text (`<scene version="3.0.0">` … `</scene>`; the tags may be left out).
std::unique_ptr<Scene> scene_from(const std::string& xml);
/// Renders sensor 0 with a seed; threads 0: all.
Image render_scene(const Scene& scene, uint64_t seed = 0, unsigned threads = 0);
/// `renders` renders with seeds `first_seed`, …: per pixel and channel (R, G, B) the mean and the
/// variance of the mean, in Image order.
std::vector<Estimate> estimate_pixels(const Scene& scene, int renders, uint64_t first_seed = 1);

/// The same of sums over tiles of tile x tile pixels: normal where a pixel's rare bright samples
/// are not yet.
std::vector<Estimate> estimate_tiles(const Scene& scene, int renders, int tile,
                                     uint64_t first_seed = 1);

/// The same of the difference a - b of renders of one seed, summed over tiles of tile x tile
/// pixels: where both scenes take the same places in their pixels, all that these contribute
/// cancels, and sums of many pixels are normal where a pixel's rare bright samples are not yet.
std::vector<Estimate> estimate_differences(const Scene& a, const Scene& b, int renders, int tile,
                                           uint64_t first_seed = 1);

/// The points that an emitter of distant light offers, whatever the scene.
std::optional<LightPoints> light_points_of(const Emitter& emitter, uint32_t count, uint64_t seed);

/// A folder that is removed at the end.
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

/// A program run with a time limit: exit status (128 + signal where killed), stdout, stderr.
struct ProcessResult {
  int status = 0;
  std::string out;
  std::string err;
};
ProcessResult run_process(const std::vector<std::string>& arguments, double timeout_seconds = 120);

}  // namespace kinome::test
