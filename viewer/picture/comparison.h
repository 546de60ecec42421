#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "picture/flip.h"
#include "picture/tone.h"

namespace kinome::viewer {

enum class Difference {
  kSigned,    ///< picture - reference, for each channel of colour
  kRelative,  ///< the same by sqrt(reference² + 0.01 mean²): the mean of its square is the relMSE
  kFlip,      ///< FLIP of what is shown, from 0 to 1
  kHdrFlip,   ///< the largest FLIP over all exposures, whatever is shown: some seconds
};
const char* to_string(Difference difference);

/// Errors of a picture, by its colours, against a reference.
struct PictureErrors {
  /// As validation/compare: mean of ((picture - reference)² - variance of the reference) /
  /// (reference² + 0.01 mean(reference)²) over pixels and channels.
  double rel_mse = 0;
  double largest = 0;   ///< of one value
  size_t left_out = 0;  ///< pixels that have a value that isn't finite, here or there
};

/// A picture, such as an EXR file has, that others are compared with. Its colours are "R", "G" and
/// "B", or "Y"; what variance it has itself are channels "variance.R", ... of the same file.
/// Immutable.
class Reference {
 public:
  /// Throws Error where the file can't be read, or has no colours.
  explicit Reference(const std::string& path);
  Reference(Image image, std::string name);

  const std::string& name() const { return name_; }
  const Image& image() const { return image_; }
  /// Throws Error where the picture has another size or no colours.
  PictureErrors errors_of(const Image& picture) const;
  /// Channels "R", "G", "B", or "Y" for kFlip and kHdrFlip; of kFlip `tone`'s curve and exposure
  /// say what is seen. kSrgb is in place of false colours. Throws Error as errors_of().
  Image difference_of(const Image& picture, Difference kind, const Tone& tone) const;

 private:
  void check(const Image& picture) const;
  /// Which pixels have no value that isn't finite.
  std::vector<bool> counted(const Image& picture) const;

  std::string name_;
  Image image_;
  ChannelGroup colors_, variance_;
};

/// The tone by which a difference is shown: signed ones in red and blue, FLIP by false colour.
Tone tone_of(Difference kind, float range);

/// What a display shows of an image's colours: for Flip.
LinearPicture displayed_picture(const Image& image, float exposure, Curve curve);

/// Of two images of one size, what is left of column `split` of the first, the rest of the second.
std::vector<uint8_t> split_view(const ToneMapper& mapper, const Image& left, const Image& right,
                                int split);

}  // namespace kinome::viewer
