// Names of Mitsuba 0.4 to 0.6.

#include "scene_xml/legacy/old_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "base/numbers.h"
#include "kinome/color.h"
#include "kinome/log.h"

namespace kinome::loader {
namespace {

struct Renaming {
  std::string_view old_name;
  std::string_view new_name;
};

constexpr Renaming kTags[] = {{"lookAt", "lookat"}, {"camera", "sensor"}, {"luminaire", "emitter"}};

/// Elements that describe nothing that can be rendered here.
constexpr std::string_view kIgnoredTags[] = {"subsurface", "null"};

bool is_older_than(const Version& version, int64_t major, int64_t minor) {
  return version < Version{major, minor, 0};
}

void add_operation(Node& transform, const char* tag, const char* axis, const char* value) {
  transform.children.insert(
      transform.children.begin(),
      Node{tag, {{axis, value, transform.where}}, {}, transform.where, nullptr});
}

/// Translates cameras from before 0.4, which were mirrored, and whose fov spanned the film's
/// smaller side.
void rename_camera(Node& node, const Version& version) {
  if (node.tag != "camera" || !is_older_than(version, 0, 4)) return;
  Node* fov_axis = nullptr;
  bool has_fov = false;
  for (Node& child : node.children) {
    const std::string name = child.value("name");
    if (name == "to_world" && child.tag == "transform") add_operation(child, "scale", "x", "-1");
    if (name == "map_smaller_side") fov_axis = &child;
    has_fov |= name == "fov";
  }
  if (!has_fov) return;
  if (!fov_axis) {
    node.children.push_back({"string",
                             {{"name", "", node.where}, {"value", "true", node.where}},
                             {},
                             node.where,
                             nullptr});
    fov_axis = &node.children.back();
  }
  fov_axis->tag = "string";
  fov_axis->find("name")->value = "fov_axis";
  if (Attribute* const value = fov_axis->find("value")) {
    value->value = value->value == "false" ? "larger" : "smaller";
  }
}

/// Translates lookAt with nine numbers, from before 0.3, which also mirrored the camera.
void rename_lookat(Node& node) {
  std::vector<Node> operations;
  for (Node& child : node.children) {
    if (child.tag == "lookat" && child.find("ox")) {
      Node lookat{"lookat", {}, {}, child.where, nullptr};
      for (const auto& [name, axes] : {std::pair{"origin", "o"}, {"target", "t"}, {"up", "u"}}) {
        std::string numbers;
        for (const char* axis : {"x", "y", "z"}) {
          const std::string value = child.value(std::string(axes) + axis);
          if (value.empty()) continue;
          if (!numbers.empty()) numbers += ' ';
          numbers += value;
        }
        if (!numbers.empty()) lookat.attributes.push_back({name, numbers, child.where});
      }
      operations.push_back({"scale", {{"x", "-1", child.where}}, {}, child.where, nullptr});
      operations.push_back(std::move(lookat));
    } else {
      operations.push_back(std::move(child));
    }
  }
  node.children = std::move(operations);
}

/// Replaces animations by their first transform.
void rename_animations(Node& node) {
  for (Node& child : node.children) {
    if (child.tag != "animation" || child.children.empty()) continue;
    log_warn(Error(child.where, "animations are replaced by their first transform").what());
    Node first = std::move(child.children.front());
    first.attributes = {{"name", child.value("name"), child.where}};
    child = std::move(first);
  }
}

void drop_ignored_tags(Node& node) {
  std::erase_if(node.children, [](const Node& child) {
    const bool is_ignored = std::find(std::begin(kIgnoredTags), std::end(kIgnoredTags),
                                      child.tag) != std::end(kIgnoredTags);
    if (is_ignored) log_warn(Error(child.where, quoted_tag(child) + " is ignored").what());
    return is_ignored;
  });
}

void rename_tag(Node& node) {
  for (const Renaming& one : kTags) {
    if (node.tag == one.old_name) node.tag = one.new_name;
  }
  if (node.tag == "transform") {
    std::erase_if(node.attributes, [](const Attribute& a) { return a.name == "time"; });
  }
}

/// Returns the colour of a hexadecimal "#rrggbb", in [0,1]; nullopt for other texts.
std::optional<std::array<double, 3>> parse_hex(const std::string& text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  std::array<double, 3> color{};
  for (size_t c = 0; c < 3; ++c) {
    int byte = 0;
    for (size_t i = 1 + 2 * c; i < 3 + 2 * c; ++i) {
      const auto lower = std::tolower(static_cast<unsigned char>(text[i]));
      const size_t digit = std::string_view("0123456789abcdef").find(static_cast<char>(lower));
      if (digit == std::string_view::npos) return std::nullopt;
      byte = byte * 16 + static_cast<int>(digit);
    }
    color[c] = byte / 255.;
  }
  return color;
}

/// Converts <srgb>, hexadecimal <rgb>, and <spectrum> of one or three numbers to <rgb>. (One number
/// is grey in Mitsuba 0.6; in Mitsuba 3 it is a constant spectrum, whose emission isn't white.)
void rename_color(Node& node, Faults& faults) {
  const bool is_encoded = node.tag == "srgb";
  if (!is_encoded && node.tag != "rgb" && node.tag != "spectrum") return;
  std::erase_if(node.attributes, [](const Attribute& a) { return a.name == "intent"; });
  Attribute* const value = node.find("value");
  if (!value || value->value.find('$') != std::string::npos) {
    if (is_encoded) node.tag = "rgb";
    return;
  }
  const auto numbers = parse_reals(value->value);
  const bool has_three = numbers && numbers->size() == 3;
  const bool is_grey = numbers && numbers->size() == 1;
  auto color = parse_hex(value->value);
  if (node.tag == "spectrum") {
    if (has_three || is_grey || color) node.tag = "rgb";
    if (!color) return;
  }
  if (!color && !is_encoded) return;
  if (!color && is_grey) color.emplace().fill(numbers->front());
  if (!color && has_three) color = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
  if (!color) {
    faults.add(value->where, "'" + value->value + "' is not a colour such as '#ff8000'");
    color.emplace();
  }
  node.tag = "rgb";
  const auto linear = [&](double v) {
    return is_encoded ? srgb_to_linear(static_cast<float>(v)) : static_cast<float>(v);
  };
  value->value = fmt::format("{:.9g} {:.9g} {:.9g}", linear((*color)[0]), linear((*color)[1]),
                             linear((*color)[2]));
}

/// Converts <blackbody name="…" temperature="5000K" scale="2"/> to a texture.
void rename_blackbody(Node& node) {
  if (node.tag != "blackbody") return;
  Node light{"texture", {{"type", "blackbody", node.where}}, {}, node.where, nullptr};
  for (Attribute& attribute : node.attributes) {
    if (attribute.name == "temperature" && attribute.value.ends_with("K")) {
      attribute.value.pop_back();
    }
    if (attribute.name == "multiplier") attribute.name = "scale";
    if (attribute.name == "temperature" || attribute.name == "scale") {
      light.children.push_back(
          {"float",
           {{"name", attribute.name, attribute.where}, {"value", attribute.value, attribute.where}},
           {},
           attribute.where,
           nullptr});
    } else {
      light.attributes.push_back(attribute);
    }
  }
  node = std::move(light);
}

}  // namespace

void rename_old(Node& node, const Version& version, Faults& faults) {
  rename_camera(node, version);
  rename_tag(node);
  rename_animations(node);
  drop_ignored_tags(node);
  if (node.tag == "transform") rename_lookat(node);
  rename_color(node, faults);
  rename_blackbody(node);
}

}  // namespace kinome::loader
