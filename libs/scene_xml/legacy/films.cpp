// Films and sensors of Mitsuba 0.x.

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "scene_xml/legacy/legacy.h"

namespace kinome::loader::legacy {
namespace {

/// Parameters that `hdrfilm` shares with the films that it replaces.
constexpr std::string_view kShared[] = {"width",         "height",      "crop_offset_x",
                                        "crop_offset_y", "crop_width",  "crop_height",
                                        "sample_border", "pixel_format"};

/// Mitsuba 0.6 wrote "luminanceAlpha", one format for each integrator of `multichannel`, and
/// spectra.
void translate_pixel_format(Node& node) {
  if (const auto alpha = take_child(node, "alpha")) {
    if (!find_child(node, "pixel_format")) {
      add_value(node, "string", "pixel_format", alpha->value("value") == "true" ? "rgba" : "rgb");
    }
  }
  Node* const format = find_child(node, "pixel_format");
  Attribute* const value = format ? format->find("value") : nullptr;
  if (!value) return;
  std::string& text = value->value;
  if (text.find(',') != std::string::npos) text = "rgb";
  constexpr std::pair<std::string_view, const char*> kFormats[] = {
      {"luminanceAlpha", "luminance_alpha"}, {"spectrum", "rgb"}, {"spectrumAlpha", "rgba"}};
  for (const auto& [old_name, new_name] : kFormats) {
    if (text == old_name) text = new_name;
  }
}

}  // namespace

void translate_film(Node& node, Warnings& warnings) {
  const std::string type = node.value("type");
  rename_child(node, "high_quality_edges", "sample_border");
  translate_pixel_format(node);
  if (type == "exrfilm" || type == "tiledhdrfilm") set_type(node, "hdrfilm");
  const bool is_encoded = type == "ldrfilm" || type == "pngfilm";
  if (!is_encoded && type != "mfilm" && type != "tiledhdrfilm") return;
  if (is_encoded) {
    warnings.add(node.where,
                 fmt::format("'{}' is replaced by 'hdrfilm', which writes linear colours: "
                             "--png also writes them as sRGB",
                             type));
  }
  if (type == "mfilm") {
    warnings.add(node.where, "'mfilm' is replaced by 'hdrfilm', which writes an image, not text");
    for (const char* side : {"width", "height"}) {
      if (!find_child(node, side)) add_value(node, "integer", side, "1");
    }
    if (!find_child(node, "pixel_format")) add_value(node, "string", "pixel_format", "luminance");
  }
  std::erase_if(node.children, [](const Node& child) {
    return kind_of(child) == TagKind::kValue && std::find(std::begin(kShared), std::end(kShared),
                                                          child.value("name")) == std::end(kShared);
  });
  set_type(node, "hdrfilm");
}

void translate_sensor(Node& node, Warnings& warnings) {
  const std::string type = node.value("type");
  rename_child(node, "focus_depth", "focus_distance");
  // Without fov, fov_axis had no effect in Mitsuba 0.x.
  if (!find_child(node, "fov")) remove_children(node, "fov_axis");
  if (type == "perspective_rdist") {
    warnings.add(node.where,
                 "'perspective_rdist' is replaced by 'perspective': the lens doesn't "
                 "distort the image");
    remove_children(node, "kc");
    set_type(node, "perspective");
  }
  if (type != "telecentric") return;
  warnings.add(node.where, "'telecentric' is replaced by 'orthographic': everything is in focus");
  for (const char* name : {"aperture_radius", "focus_distance"}) remove_children(node, name);
  set_type(node, "orthographic");
}

}  // namespace kinome::loader::legacy
