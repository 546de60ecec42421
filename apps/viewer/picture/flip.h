#pragma once

#include <memory>
#include <vector>

#include "kinome/color.h"

namespace kinome::viewer {

/// FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", DOI
/// 10.1145/3406183) estimates the differences, from 0 to 1 per pixel, that a viewer notices when
/// two images alternate. Pixels outside the image repeat its edge.
///
/// `pixels_per_degree` is the number of pixels per degree of the visual field. This default, of the
/// paper, is for a 4K screen of 0.7 m at a distance of 0.7 m.
inline constexpr float kPixelsPerDegree = 67.0206433f;

/// Linear Rec.709, rows from the top.
struct LinearPicture {
  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;
};

/// Computes FLIP between displayed images: linear light in [0,1]. The reference is processed once,
/// which saves half of the time of further comparisons. Immutable.
class Flip {
 public:
  explicit Flip(const LinearPicture& reference, float pixels_per_degree = kPixelsPerDegree);
  ~Flip();
  /// Returns the difference of each pixel. The image must have the size of the reference.
  std::vector<float> differences(const LinearPicture& picture) const;

 private:
  struct Seen;
  static std::unique_ptr<const Seen> see(const LinearPicture& picture, float pixels_per_degree);
  float pixels_per_degree_;
  std::unique_ptr<const Seen> reference_;
};

/// Exposures at which HDR images are compared (Andersson et al. 2021, "Visualizing and
/// Communicating Errors in Rendered Images", DOI 10.1007/978-1-4842-7185-8_19). At the first
/// exposure, filmic() maps the reference's largest luminance to 0.85; at the last, the median.
struct Exposures {
  float first, last;  ///< in stops
  int count;
  float at(int i) const { return first + (last - first) * static_cast<float>(i) / (count - 1); }
};
Exposures flip_exposures(const LinearPicture& reference);

/// Returns the maximum difference of each pixel over all exposures, displayed by filmic(). The
/// input is radiance >= 0. Takes Exposures::count times as long as Flip.
std::vector<float> hdr_flip(const LinearPicture& reference, const LinearPicture& picture,
                            float pixels_per_degree = kPixelsPerDegree);

double mean_of(const std::vector<float>& values);

}  // namespace kinome::viewer
