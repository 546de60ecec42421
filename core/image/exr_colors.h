#pragma once

#include <ImfChannelList.h>
#include <ImfHeader.h>

#include <string>
#include <vector>

#include "kinome/image.h"

/// The channels of an EXR file that are its colour, and their conversion to linear Rec.709.
namespace kinome {

/// From the best choice to the worst, of a file's parts as well: a colour without a layer's name
/// comes first.
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
  /// As the file names them: R, G, B or X, Y, Z or Y or Y, RY, BY, and then alpha if there is one.
  std::vector<std::string> channels;
  /// The names of `channels` in an Image: "R", "G", "B" or "Y", and "A".
  std::vector<std::string> names;
  /// Layers that are colours, too, and were not chosen.
  std::vector<std::string> other_layers;
};

/// Finds letters of either case, with or without the name of a layer before them: "R", ".R",
/// "ViewLayer.Combined.r". Of several layers, chooses one with the name of a whole image
/// ("Combined", "beauty", "rgba", …), else the file's first. Y beside X is part of a vector.
ExrColor find_exr_color(const Imf::ChannelList& list);

/// Converts the first three channels, if they are R, G and B. XYZ has no primaries of its own;
/// the header's attribute `chromaticities` is used for all others. No adaptation of the white.
/// Throws std::runtime_error for chromaticities that span no colours.
void convert_to_rec709(const Imf::Header& header, ExrColorKind kind, Image& image);

}  // namespace kinome
