// Emitters of Mitsuba 0.x: sun and sky with +y up, and names from before 0.4.

#include <algorithm>

#include "base/numbers.h"
#include "scene_xml/legacy/legacy.h"

namespace kinome::loader::legacy {
namespace {

/// Apparent diameter of the sun, in degrees.
constexpr double kSunAperture = 0.5358;
/// Smallest diameter, in degrees; also used for a sun without extent.
constexpr double kMinAperture = 0.01;
constexpr double kOldAlbedo = 0.15;

/// In Mitsuba 0.6, +y is up, north is -z and east +x. In Mitsuba 3, +z is up, north is -x and east
/// -y, which is the mirror image.
constexpr const char* kOldAxes = "0 -1 0 0  0 0 1 0  1 0 0 0  0 0 0 1";

/// Puts the change of axes before the operations of the file's to_world.
void turn_axes(Node& node) {
  Node axes{"matrix", {{"value", kOldAxes, node.where}}, {}, node.where, nullptr};
  if (Node* const to_world = find_child(node, "to_world")) {
    to_world->children.insert(to_world->children.begin(), std::move(axes));
    return;
  }
  node.children.push_back(
      {"transform", {{"name", "to_world", node.where}}, {std::move(axes)}, node.where, nullptr});
}

/// Translates scales to `sun_scale` and `sky_scale`. `sun` and `sky` have one scale each; that of
/// `sunsky` is the default of both.
void translate_scales(Node& node, const std::string& type) {
  const double scale = number_of(node, "scale", 1);
  remove_children(node, "scale");
  for (const char* part : {"sun", "sky"}) {
    const std::string name = std::string(part) + "_scale";
    if (type == "sunsky") {
      if (!find_child(node, name) && scale != 1) add_number(node, name, scale);
    } else {
      remove_children(node, name);
      add_number(node, name, type == part ? scale : 0);
    }
  }
}

void translate_sunsky(Node& node, Warnings& warnings) {
  const std::string type = node.value("type");
  translate_scales(node, type);
  if (find_child(node, "sun_radius_scale")) {
    const double scale = number_of(node, "sun_radius_scale", 1);
    remove_children(node, "sun_radius_scale");
    add_number(node, "sun_aperture", std::max(kSunAperture * scale, kMinAperture));
  }
  if (number_of(node, "stretch", 1) != 1 || child_value(node, "extend") == "true") {
    warnings.add(node.where, "'stretch' and 'extend' are ignored: the sky ends at the horizon");
  }
  for (const char* name : {"resolution", "stretch", "extend"}) remove_children(node, name);
  if (find_child(node, "sun_direction")) {
    for (const char* name : {"latitude", "longitude", "timezone", "year", "month", "day", "hour",
                             "minute", "second"}) {
      remove_children(node, name);
    }
  }
  if (!find_child(node, "albedo")) add_number(node, "albedo", kOldAlbedo);
  turn_axes(node);
  set_type(node, "sunsky");
}

}  // namespace

void translate_emitter(Node& node, Warnings& warnings) {
  const std::string type = node.value("type");
  if (type == "sunsky" || type == "sun" || type == "sky") translate_sunsky(node, warnings);
  if (type == "area" || type == "constant") rename_child(node, "intensity", "radiance");
  if (type == "directional") rename_child(node, "intensity", "irradiance");
  if (type == "envmap") rename_child(node, "intensity_scale", "scale");
}

}  // namespace kinome::loader::legacy
