#pragma once

#include <memory>
#include <vector>

#include "kinome/color.h"

namespace kinome::viewer {

/// Differences between two pictures as they are noticed when one is shown in place of the other,
/// for each pixel from 0 to 1: FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for
/// Alternating Images", DOI 10.1145/3406183). Edges repeat beyond the picture.
///
/// `pixels_per_degree`: how many pixels a degree of the visual field has; the paper's is a 4K
/// screen of 0.7 m seen from 0.7 m.
inline constexpr float kPixelsPerDegree = 67.0206433f;

/// Linear Rec.709, rows from the top.
struct LinearPicture {
  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;
};

/// Of what a display shows: linear light in [0,1]. A reference may be prepared once, and takes half
/// the time. Immutable.
class Flip {
 public:
  explicit Flip(const LinearPicture& reference, float pixels_per_degree = kPixelsPerDegree);
  ~Flip();
  /// Of a picture of the same size.
  std::vector<float> differences(const LinearPicture& picture) const;

 private:
  struct Seen;
  static std::unique_ptr<const Seen> see(const LinearPicture& picture, float pixels_per_degree);
  float pixels_per_degree_;
  std::unique_ptr<const Seen> reference_;
};

/// The exposures at which HDR pictures are compared (Andersson et al. 2021, "Visualizing and
/// Communicating Errors in Rendered Images", DOI 10.1007/978-1-4842-7185-8_19): from the one at
/// which the reference's median luminance to the one at which its largest is shown as 0.85 by
/// filmic().
struct Exposures {
  float first, last;  ///< in stops
  int count;
  float at(int i) const { return first + (last - first) * static_cast<float>(i) / (count - 1); }
};
Exposures flip_exposures(const LinearPicture& reference);

/// Of radiance >= 0: the largest difference of each pixel over all exposures, each shown by
/// filmic(). Takes Exposures::count times as long as Flip.
std::vector<float> hdr_flip(const LinearPicture& reference, const LinearPicture& picture,
                            float pixels_per_degree = kPixelsPerDegree);

double mean_of(const std::vector<float>& values);

}  // namespace kinome::viewer
