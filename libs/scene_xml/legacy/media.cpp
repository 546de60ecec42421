// Media and volumes of Mitsuba 0.x.

#include <fmt/format.h>

#include "kinome/color.h"
#include "scene_xml/legacy/legacy.h"
#include "scene_xml/values/convert.h"

namespace kinome::loader::legacy {
namespace {

/// Returns the colour of a child. Returns nullopt if the child is missing or invalid; invalid
/// values are reported when the object's parameters are read.
std::optional<Rgb> color_of(Node& node, std::string_view name) {
  const Node* const child = find_child(node, name);
  if (!child || child->is_broken) return std::nullopt;
  try {
    const Properties::Value value = convert(*child, nullptr, {});
    if (const auto* number = std::get_if<double>(&value)) return Rgb(static_cast<float>(*number));
    if (const auto* color = std::get_if<UniformColor>(&value)) return color->value;
  } catch (const Error&) {
  }
  return std::nullopt;
}

/// Adds a uniform volume, which unlike a colour isn't restricted to [0,1].
void add_volume(Node& node, const std::string& name, const Rgb& value) {
  Node volume = make_object("volume", "constvolume", node.where);
  volume.attributes.push_back({"name", name, node.where});
  add_value(volume, "rgb", "value", fmt::format("{:.9g} {:.9g} {:.9g}", value.x, value.y, value.z));
  node.children.push_back(std::move(volume));
}

/// Replaces absorption and scattering coefficients by extinction and albedo.
void translate_homogeneous(Node& node, Warnings& warnings) {
  if (find_child(node, "material")) {
    warnings.add(node.where, "'material' of a medium is ignored: give sigma_t and albedo");
    remove_children(node, "material");
  }
  const auto absorption = color_of(node, "sigma_a"), scattering = color_of(node, "sigma_s");
  if (absorption && scattering) {
    const Rgb extinction = *absorption + *scattering;
    for (const char* name : {"sigma_a", "sigma_s", "sigma_t", "albedo"})
      remove_children(node, name);
    add_volume(node, "sigma_t", extinction);
    add_volume(node, "albedo", *scattering / glm::max(extinction, Rgb(1e-30f)));
  } else if (const auto extinction = color_of(node, "sigma_t")) {
    remove_children(node, "sigma_t");
    add_volume(node, "sigma_t", *extinction);
  }
}

}  // namespace

void translate_medium(Node& node, Warnings& warnings) {
  rename_child(node, "density_multiplier", "scale");
  remove_children(node, "method");
  if (node.value("type") == "homogeneous") translate_homogeneous(node, warnings);
  if (node.value("type") == "heterogeneous") rename_child(node, "density", "sigma_t");
}

/// Grids of Mitsuba 0.x have the place that their file states.
void translate_volume(Node& node) {
  if (node.value("type") != "gridvolume") return;
  remove_children(node, "send_data");
  if (!find_child(node, "use_grid_bbox")) add_value(node, "boolean", "use_grid_bbox", "true");
}

}  // namespace kinome::loader::legacy
