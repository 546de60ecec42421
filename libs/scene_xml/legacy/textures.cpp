// Textures of Mitsuba 0.x.

#include <algorithm>

#include <fmt/format.h>

#include "base/numbers.h"
#include "scene_xml/legacy/legacy.h"

namespace kinome::loader::legacy {
namespace {

/// Appends a transform operation from the children `u` and `v` of a texture, which are removed.
/// Appends nothing if it has neither.
void take_operation(Node& texture, const char* tag, const char* u, const char* v,
                    std::vector<Node>& operations) {
  Node operation{tag, {}, {}, {}, nullptr};
  for (const auto& [old_name, axis] : {std::pair{u, "x"}, std::pair{v, "y"}}) {
    const auto child = take_child(texture, old_name);
    const Attribute* const value = child ? child->find("value") : nullptr;
    if (!value) continue;
    operation.where = child->where;
    operation.attributes.push_back({axis, value->value, value->where});
  }
  if (!operation.attributes.empty()) operations.push_back(std::move(operation));
}

/// Replaces uoffset, voffset, uscale and vscale by to_uv, which moves first, then scales.
void translate_coordinates(Node& texture) {
  std::vector<Node> operations;
  take_operation(texture, "translate", "uoffset", "voffset", operations);
  take_operation(texture, "scale", "uscale", "vscale", operations);
  if (operations.empty()) return;
  const Location where = operations.front().where;
  texture.children.push_back(
      {"transform", {{"name", "to_uv", where}}, std::move(operations), where, nullptr});
}

/// Merges the wrap modes for u and v, and replaces the modes 'zero' and 'one'.
void translate_wrap_mode(Node& node, Warnings& warnings) {
  const std::string u = child_value(node, "wrap_mode_u"), v = child_value(node, "wrap_mode_v");
  if (!u.empty() && !v.empty() && u != v) {
    warnings.add(node.where,
                 "'wrap_mode_u' is used for both coordinates, and 'wrap_mode_v' is "
                 "ignored");
  }
  rename_child(node, "wrap_mode_u", "wrap_mode");
  rename_child(node, "wrap_mode_v", "wrap_mode");
  for (const char* name : {"wrap_mode_u", "wrap_mode_v"}) remove_children(node, name);
  Node* const mode = find_child(node, "wrap_mode");
  Attribute* const value = mode ? mode->find("value") : nullptr;
  if (!value || (value->value != "zero" && value->value != "one")) return;
  warnings.add(mode->where, fmt::format("the wrap mode '{}' is replaced by 'clamp'", value->value));
  value->value = "clamp";
}

/// Translates `gamma`, whose value 1 means raw data, and filters of mip maps, which Mitsuba 3
/// lacks.
void translate_bitmap(Node& node, Warnings& warnings) {
  translate_wrap_mode(node, warnings);
  if (Node* const filter = find_child(node, "filter_type")) {
    Attribute* const value = filter->find("value");
    if (value && (value->value == "trilinear" || value->value == "ewa")) value->value = "bilinear";
  }
  const auto gamma = take_child(node, "gamma");
  if (!gamma) return;
  const auto value = parse_real(gamma->value("value"));
  if (value == 1. && !find_child(node, "raw")) {
    add_value(node, "boolean", "raw", "true");
  } else if (value && *value > 0 && *value != 1. && *value != 2.2) {
    warnings.add(gamma->where, "'gamma' is ignored: the image file's own encoding is used");
  }
}

/// Replaces a wireframe by the colour between its lines, which are thin.
void translate_wireframe(Node& node, Warnings& warnings) {
  warnings.add(node.where, "'wireframe' is replaced by the colour between its lines");
  auto color = take_child(node, "interior_color");
  node.children.clear();
  if (!color) {
    add_number(node, "interior_color", 0.5);
    color = take_child(node, "interior_color");
  }
  for (const char* name : {"color0", "color1"}) {
    node.children.push_back(*color);
    node.children.back().find("name")->value = name;
  }
  set_type(node, "checkerboard");
}

}  // namespace

void translate_texture(Node& node, Warnings& warnings) {
  std::string type = node.value("type");
  if (type == "ldrtexture" || type == "exrtexture") set_type(node, type = "bitmap");
  if (type == "vertexcolors") {
    warnings.add(node.where,
                 "'vertexcolors' is replaced by 'mesh_attribute', and colours are read "
                 "as numbers between 0 and 255");
    set_type(node, "mesh_attribute");
    add_value(node, "string", "name", "vertex_color");
    add_number(node, "scale", 1. / 255);
  }
  if (type == "wireframe") translate_wireframe(node, warnings);
  if (type == "checkerboard" || type == "gridtexture") {
    rename_child(node, "bright_color", "color0");
    rename_child(node, "dark_color", "color1");
  }
  if (type == "bitmap") translate_bitmap(node, warnings);
  translate_coordinates(node);
}

}  // namespace kinome::loader::legacy
