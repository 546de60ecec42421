#include "image_files/exr_colors.h"

#include <ImfChromaticities.h>
#include <ImfStandardAttributes.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <stdexcept>

#include "kinome/color.h"

namespace kinome {
namespace {

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Channels of one layer: maps the part of the name after the last dot to the whole name.
struct Layer {
  std::map<std::string, std::string> channels;

  bool has(std::initializer_list<const char*> suffixes) const {
    return std::all_of(suffixes.begin(), suffixes.end(),
                       [this](const char* suffix) { return find(suffix) != nullptr; });
  }
  /// Returns the name of the channel `suffix` or, if there is none, of its lower-case form; nullptr
  /// if neither exists.
  const std::string* find(const std::string& suffix) const {
    for (const std::string& spelling : {suffix, lower_case(suffix)}) {
      const auto found = channels.find(spelling);
      if (found != channels.end()) return &found->second;
    }
    return nullptr;
  }
  ExrColor color(ExrColorKind kind, std::initializer_list<const char*> suffixes,
                 std::vector<std::string> names) const {
    ExrColor color{kind, {}, std::move(names), {}};
    for (const char* suffix : suffixes) color.channels.push_back(*find(suffix));
    if (const std::string* const alpha = find("A")) {
      color.channels.push_back(*alpha);
      color.names.emplace_back("A");
    }
    return color;
  }
};

/// Returns layers by name. Channels without a dot belong to the layer "".
std::map<std::string, Layer> layers_of(const Imf::ChannelList& list) {
  std::map<std::string, Layer> layers;
  for (auto it = list.begin(); it != list.end(); ++it) {
    const std::string name = it.name();
    const size_t dot = name.rfind('.');
    const std::string layer = dot == std::string::npos ? "" : name.substr(0, dot);
    layers[layer].channels.emplace(dot == std::string::npos ? name : name.substr(dot + 1), name);
  }
  return layers;
}

bool is_luminance(const Layer& layer) {
  return layer.has({"Y"}) && !layer.has({"X"});
}

ExrColor color_without_layer(const Layer& layer) {
  using enum ExrColorKind;
  if (layer.has({"R", "G", "B"})) return layer.color(kRgb, {"R", "G", "B"}, {"R", "G", "B"});
  // OpenEXR requires these exact names.
  if (layer.has({"Y", "RY", "BY"}) && *layer.find("Y") == "Y" && *layer.find("RY") == "RY" &&
      *layer.find("BY") == "BY") {
    return layer.color(kLuminanceChroma, {"Y", "RY", "BY"}, {"R", "G", "B"});
  }
  // Lower-case x, y, z are positions or normals.
  const auto& all = layer.channels;
  if (all.contains("X") && all.contains("Y") && all.contains("Z")) {
    return layer.color(kXyz, {"X", "Y", "Z"}, {"R", "G", "B"});
  }
  if (is_luminance(layer)) return layer.color(kLuminance, {"Y"}, {"Y"});
  return {};
}

/// Returns true if renderers and compositors use this layer name for the whole image.
bool is_whole_image(const std::string& layer) {
  constexpr std::array kNames{"combined", "beauty", "rgba", "rgb", "composite", "color", "colour"};
  const std::string last = lower_case(layer.substr(layer.rfind('.') + 1));
  return std::find(kNames.begin(), kNames.end(), last) != kNames.end();
}

/// Returns true if two sets of primaries and white differ by rounding only. The threshold is that
/// of Mitsuba 3, which doesn't convert such files either.
bool are_same(const Imf::Chromaticities& a, const Imf::Chromaticities& b) {
  constexpr float kSquaredDistance = 1e-6f;
  return (a.red - b.red).length2() + (a.green - b.green).length2() + (a.blue - b.blue).length2() +
             (a.white - b.white).length2() <
         kSquaredDistance;
}

using Matrix = std::array<std::array<float, 3>, 3>;  // by row

/// Returns the matrix from the file's colours to linear Rec.709. Both whites have Y = 1, without
/// chromatic adaptation. Throws std::runtime_error if the primaries don't span a triangle.
Matrix matrix_to_rec709(const Imf::Chromaticities& file) {
  // Colour spaces in use have coordinates in [-0.1, 1.1] and areas of at least 0.1 (Rec.709).
  // Within these limits, floats distinguish a triangle from a line.
  constexpr float kMaxCoordinate = 10;
  constexpr float kMinTwiceArea = 1e-4f, kMinWhiteY = 1e-4f;
  bool is_usable = true;
  for (const Imath::V2f& v : {file.red, file.green, file.blue, file.white}) {
    is_usable = is_usable && std::abs(v.x) <= kMaxCoordinate && std::abs(v.y) <= kMaxCoordinate;
  }
  const float twice_area = (file.green - file.red).cross(file.blue - file.red);
  if (!is_usable || !(std::abs(twice_area) >= kMinTwiceArea) ||
      !(std::abs(file.white.y) >= kMinWhiteY)) {
    throw std::runtime_error(fmt::format(
        "its attribute 'chromaticities' is invalid: red ({}, {}), green ({}, {}), blue ({}, {}), "
        "white ({}, {}); the primaries must span a triangle, and white's y must not be 0",
        file.red.x, file.red.y, file.green.x, file.green.y, file.blue.x, file.blue.y, file.white.x,
        file.white.y));
  }
  // OpenEXR multiplies rows by its matrices.
  const Imath::M44f m = Imf::RGBtoXYZ(file, 1) * Imf::XYZtoRGB(Imf::Chromaticities(), 1);
  return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}

/// Returns the inverse of xyz(), the conversion with which films write XYZ.
Matrix matrix_of_xyz() {
  const glm::dmat3 m = glm::inverse(glm::dmat3(xyz({1, 0, 0}), xyz({0, 1, 0}), xyz({0, 0, 1})));
  Matrix rows;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rows[r][c] = static_cast<float>(m[c][r]);
  }
  return rows;
}

}  // namespace

ExrColor find_exr_color(const Imf::ChannelList& list) {
  using enum ExrColorKind;
  const std::map<std::string, Layer> layers = layers_of(list);
  const auto unnamed = layers.find("");
  if (unnamed != layers.end()) {
    ExrColor color = color_without_layer(unnamed->second);
    if (color.kind != kNone) return color;
  }
  std::vector<std::string> candidates;
  for (const auto& [name, layer] : layers) {
    if (layer.has({"R", "G", "B"})) candidates.push_back(name);
  }
  const bool is_rgb = !candidates.empty();
  for (const auto& [name, layer] : layers) {
    if (!is_rgb && is_luminance(layer)) candidates.push_back(name);
  }
  if (candidates.empty()) return {};
  auto chosen = std::find_if(candidates.begin(), candidates.end(), is_whole_image);
  const bool is_named = chosen != candidates.end();
  if (!is_named) chosen = candidates.begin();
  const Layer& layer = layers.at(*chosen);
  ExrColor color = is_rgb ? layer.color(kLayerRgb, {"R", "G", "B"}, {"R", "G", "B"})
                          : layer.color(kLayerLuminance, {"Y"}, {"Y"});
  candidates.erase(chosen);
  if (!is_named) color.other_layers = std::move(candidates);
  return color;
}

void convert_to_rec709(const Imf::Header& header, ExrColorKind kind, Image& image) {
  const bool is_rgb = image.channels.size() >= 3 && image.channels[0] == "R" &&
                      image.channels[1] == "G" && image.channels[2] == "B";
  if (!is_rgb) return;
  Matrix matrix;
  if (kind == ExrColorKind::kXyz) {
    matrix = matrix_of_xyz();
  } else {
    if (!Imf::hasChromaticities(header)) return;
    const Imf::Chromaticities& file = Imf::chromaticities(header);
    if (are_same(file, Imf::Chromaticities())) return;
    matrix = matrix_to_rec709(file);
  }
  for (size_t i = 0; i < image.data.size(); i += image.channels.size()) {
    float* const pixel = &image.data[i];
    const std::array<float, 3> color{pixel[0], pixel[1], pixel[2]};
    for (int c = 0; c < 3; ++c) {
      pixel[c] = color[0] * matrix[c][0] + color[1] * matrix[c][1] + color[2] * matrix[c][2];
    }
  }
}

}  // namespace kinome
