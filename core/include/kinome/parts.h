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

/// Pictures whose samples are rendered in parts: by several programs that know nothing of each
/// other, on any machines, and added afterwards.
///
/// Part i of n is the scene's render with its number of samples divided by n (rounded up), and a
/// seed of its own, made of the render's seed and i. All parts count alike, each is unbiased, and
/// no two have random numbers in common. The whole is their sum, added in the order of the parts:
/// it has the same bits whoever made them, as long as they took the same instruction set.
namespace kinome {

/// Parts of a picture. Counted from 0 here, and from 1 by what people read.
struct PicturePart {
  static constexpr uint32_t kMost = 65536;
  uint32_t index = 0;
  uint32_t count = 1;
};

/// One part: rendered, and written. Not thread-safe.
class KINOME_EXPORT PartRender {
 public:
  /// Scene and sensor must live as long. Error where no files of parts can be written of the
  /// sensor's film.
  PartRender(const Scene& scene, const Sensor& sensor, const PicturePart& part);
  /// Into the sensor's film, as kinome::render() does by a number of samples; the context's budget
  /// must ask for nothing. Where it is interrupted, gaps are left as they are: their share is
  /// RenderStats::missing.
  Image render(RenderContext& context) const;
  /// After render(), the picture as the film writes it, with a second one in the same EXR file that
  /// holds the film's sums, bit by bit, and that programs which show the first don't care about.
  /// `metadata`: of the first. Throws Error as the film does.
  void write(const std::string& path, const Image& image, const ImageMetadata& metadata) const;

 private:
  const Scene& scene_;
  const Sensor& sensor_;
  PicturePart part_;
  float response_;  ///< of the film: Film::set_response
};

/// Renders all parts, one after another, and adds them: what merge_parts() makes of their files.
/// Takes memory for as many films. Otherwise as PartRender::render.
KINOME_EXPORT Image render_all_parts(const Scene& scene, const Sensor& sensor,
                                     RenderContext& context, uint32_t count);

/// What the header of a picture of so many parts says beside Kinome's other attributes.
KINOME_EXPORT ImageMetadata metadata_of_parts(uint32_t count);

/// Pictures that were merged.
struct MergedParts {
  Image image;
  ImageMetadata metadata;
  std::shared_ptr<Film> film;                 ///< writes the image
  uint32_t count = 0;                         ///< parts that the whole picture has
  std::vector<uint32_t> missing, incomplete;  ///< counted from 1
  uint64_t non_finite = 0;                    ///< samples that were dropped
  double gaps = 0;                            ///< share of the pixels that have no samples
  /// They were rendered with several instruction sets, whose results differ in their last bits.
  bool is_mixed = false;
};
/// Adds files of parts, given in any order. Throws Error, with the names of files, where these
/// aren't parts of the same picture, one is there twice, or can't be read; and, unless
/// `allows_missing`, where one is missing or was interrupted. Takes memory for one film, however
/// many files there are.
KINOME_EXPORT MergedParts merge_parts(const std::vector<std::string>& paths, bool allows_missing,
                                      PluginRegistry& registry);

}  // namespace kinome
