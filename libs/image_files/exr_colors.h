#pragma once

#include <ImfChannelList.h>
#include <ImfHeader.h>

#include <string>
#include <vector>

#include "kinome/image.h"

/// Finds the colour channels of an EXR file and converts them to linear Rec.709.
namespace kinome {

/// Kinds of colour, from the best to the worst choice. Channels without a layer name come first.
/// The order also decides between the parts of a file.
enum class ExrColorKind {
  kRgb,
  kLuminanceChroma,
  kXyz,
  kLuminance,
  kLayerRgb,
  kLayerLuminance,
  kNone
};

struct ExrColor {
  ExrColorKind kind = ExrColorKind::kNone;
  /// Names of the channels in the file: of R, G, B, of X, Y, Z, of Y, or of Y, RY, BY, and then of
  /// alpha if there is one.
  std::vector<std::string> channels;
  /// Names of the same channels in an Image: "R", "G", "B" or "Y", and "A".
  std::vector<std::string> names;
  /// Other layers with colour, which were not chosen.
  std::vector<std::string> other_layers;
};

/// Finds the colour channels of a file. Names may be upper or lower case, and may have a layer
/// prefix: "R", ".R", "ViewLayer.Combined.r". Of several layers, chooses one whose name stands for
/// the whole image ("Combined", "beauty", "rgba", …), or else the file's first. A layer with X and
/// Y contains vectors, not a luminance.
ExrColor find_exr_color(const Imf::ChannelList& list);

/// Converts the first three channels if they are R, G and B. XYZ is converted without primaries;
/// all other kinds use the header's attribute `chromaticities`. There is no chromatic adaptation.
/// Throws std::runtime_error if the primaries don't span a triangle.
void convert_to_rec709(const Imf::Header& header, ExrColorKind kind, Image& image);

}  // namespace kinome
