#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "kinome/plugin_registry.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"

/// Images whose samples are rendered in parts, by independent programs on any machines, and merged
/// afterwards.
///
/// Part i of n is the scene's render with its sample count divided by n (rounded up), and a seed
/// derived from the render's seed and i. All parts have equal weight, each is unbiased, and no two
/// share random numbers. The image is their sum in the order of the parts. Its bits don't depend on
/// who rendered the parts, as long as all use the same instruction set.
namespace kinome {

/// Part of an image. Counts from 0 in code, and from 1 in everything that users read.
struct ImagePart {
  static constexpr uint32_t kMaxParts = 65536;
  uint32_t index = 0;
  uint32_t count = 1;
};

/// Render of one part, and its output file. Not thread-safe.
class KINOME_EXPORT PartRender {
 public:
  /// Scene and sensor must outlive this object. Throws Error if the sensor's film can't write files
  /// of parts.
  PartRender(const Scene& scene, const Sensor& sensor, const ImagePart& part);
  /// Renders into the sensor's film, as kinome::render() does with a sample count; the context's
  /// budget must be empty. If the render is interrupted, pixels without samples stay empty;
  /// RenderStats::missing is their share.
  Image render(RenderContext& context) const;
  /// Writes the image after render(), as the film writes it, with `metadata`. A second part of the
  /// same EXR file contains the film's sums exactly; programs that show the image ignore it. Throws
  /// Error as the film does.
  void write(const std::string& path, const Image& image, const ImageMetadata& metadata) const;

 private:
  const Scene& scene_;
  const Sensor& sensor_;
  ImagePart part_;
};

/// Renders all parts, one after another, and adds them. The result is that of merge_parts() on
/// their files. Needs memory for `count` films. Otherwise like PartRender::render().
KINOME_EXPORT Image render_all_parts(const Scene& scene, const Sensor& sensor,
                                     RenderContext& context, uint32_t count);

/// Returns the metadata that an image of `count` parts has in addition to Kinome's other
/// attributes.
KINOME_EXPORT ImageMetadata metadata_of_parts(uint32_t count);

/// Result of merging parts.
struct MergedParts {
  Image image;
  ImageMetadata metadata;
  std::shared_ptr<Film> film;                 ///< film that writes the image
  uint32_t count = 0;                         ///< number of parts of the whole image
  std::vector<uint32_t> missing, incomplete;  ///< parts, counted from 1
  uint64_t non_finite = 0;                    ///< number of dropped samples
  double gaps = 0;                            ///< share of pixels without samples
  /// True if parts were rendered with different instruction sets, whose results differ in the last
  /// bits.
  bool is_mixed = false;
};
/// Merges files of parts, in any order. Throws Error with the names of files if they are not parts
/// of the same image, one occurs twice, or one can't be read. Unless `allows_missing`, also throws
/// if a part is missing or was interrupted. Needs memory for one film, for any number of files.
///
/// If `estimates_noise` is true and there are at least two parts, adds the channels of film_noise()
/// to the image; parts are independent renders. This reads the parts twice, and needs memory for
/// one further film per part, at most eight.
KINOME_EXPORT MergedParts merge_parts(const std::vector<std::string>& paths, bool allows_missing,
                                      PluginRegistry& registry, bool estimates_noise = false);

}  // namespace kinome
