#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "picture/flip.h"
#include "picture/tone.h"

namespace kinome::viewer {

enum class Difference {
  kSigned,    ///< image - reference, for each colour channel
  kRelative,  ///< kSigned / sqrt(reference² + 0.01 mean²); the mean of its square is the relMSE
  kFlip,      ///< FLIP of the displayed images, from 0 to 1
  kHdrFlip,   ///< maximum FLIP over all exposures, independent of the display; takes some seconds
};
const char* to_string(Difference difference);

/// Errors of an image's colours against a reference.
struct PictureErrors {
  /// Mean of ((image - reference)² - variance of the reference) / (reference² +
  /// 0.01 mean(reference)²) over pixels and channels, as in validation/compare.
  double rel_mse = 0;
  double largest = 0;   ///< maximum of the averaged terms
  size_t left_out = 0;  ///< number of pixels with a non-finite value in either image
};

/// A reference image for comparisons, for example from an EXR file. Its colours are the channels
/// "R", "G" and "B", or "Y". Channels "variance.R", ... contain its own variance, if known.
/// Immutable.
class Reference {
 public:
  /// Throws Error if the file can't be read or has no colours.
  explicit Reference(const std::string& path);
  Reference(Image image, std::string name);

  const std::string& name() const { return name_; }
  const Image& image() const { return image_; }
  /// Throws Error if the image's size or colour channels are not those of the reference.
  PictureErrors errors_of(const Image& picture) const;
  /// Returns an image of the difference with the channels "R", "G", "B", or "Y" for kFlip and
  /// kHdrFlip. kFlip displays both images with `tone`'s exposure and curve, with kSrgb instead of
  /// false colours. Throws Error like errors_of().
  Image difference_of(const Image& picture, Difference kind, const Tone& tone) const;

 private:
  void check(const Image& picture) const;
  /// Returns for each pixel whether all of its values are finite.
  std::vector<bool> counted(const Image& picture) const;

  std::string name_;
  Image image_;
  ChannelGroup colors_, variance_;
};

/// Returns the tone mapping for a difference: red and blue for signed values, false colours for
/// FLIP.
Tone tone_of(Difference kind, float range);

/// Returns an image's colours as displayed, as input of Flip.
LinearPicture displayed_picture(const Image& image, float exposure, Curve curve);

/// Combines two images of equal size: `left` in the columns before `split`, `right` in the others.
std::vector<uint8_t> split_view(const ToneMapper& mapper, const Image& left, const Image& right,
                                int split);

/// Selects what is displayed of an image and its reference.
enum class Shown { kPicture, kReference, kSplit, kDifference };

/// Settings for the conversion of images to display pixels. Not thread-safe.
struct Display {
  Tone tone;
  Shown shown = Shown::kPicture;
  std::shared_ptr<const Reference> reference;  ///< nullptr if there is none; displays kPicture
  float split = 0.5f;                          ///< fraction of the width that displays the image
  std::shared_ptr<const Image> difference;     ///< nullptr if it isn't computed yet
  Tone difference_tone;

  /// Converts an image to sRGB with 4 bytes per pixel. Resamples a reference of another size, for
  /// example beside a preview. Displays the image if there is no difference of its size.
  void map(const Image& picture, std::vector<uint8_t>& rgba) const;
};

/// Resamples to the nearest pixel.
Image resampled(const Image& image, int width, int height);

/// Result of a comparison with a reference.
struct Comparison {
  PictureErrors errors;
  double flip = 0;  ///< mean over the image
  std::shared_ptr<const Image> difference;
  std::string fault;  ///< error message if the comparison failed, otherwise ""
};

/// Compares an image, displayed with `tone`, with a reference. Takes about 0.1 s for 640x480
/// pixels. Doesn't throw; errors are in Comparison::fault.
Comparison compare(const Image& picture, const Reference& reference, Difference kind,
                   const Tone& tone);

}  // namespace kinome::viewer
