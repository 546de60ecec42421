// Integrators of Mitsuba 0.x.

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/numbers.h"
#include "scene_xml/legacy/legacy.h"

namespace kinome::loader::legacy {
namespace {

/// Integrators that converge to the same image as `path`.
constexpr std::string_view kSameImage[] = {"bdpt", "erpt",   "mlt",  "photonmapper",
                                           "ppm",  "pssmlt", "sppm", "vpl"};
constexpr std::string_view kKept[] = {"max_depth", "rr_depth", "hide_emitters"};

/// Values of a `field` integrator, and the variables of `aov` that replace them.
constexpr std::pair<std::string_view, std::string_view> kFields[] = {
    {"position", "position"},    {"relPosition", "position"},   {"distance", "depth"},
    {"geoNormal", "geo_normal"}, {"shNormal", "sh_normal"},     {"uv", "uv"},
    {"albedo", "albedo"},        {"shapeIndex", "shape_index"}, {"primIndex", "prim_index"},
};

template <class Names>
void keep_only(Node& node, const Names& names) {
  std::erase_if(node.children, [&](const Node& child) {
    return kind_of(child) == TagKind::kValue &&
           std::find(std::begin(names), std::end(names), child.value("name")) == std::end(names);
  });
}

/// Warns if the value of pixels without a surface isn't 0, because `aov` has no such parameter.
void warn_of_undefined(Node& field, Warnings& warnings) {
  const Node* const undefined = find_child(field, "undefined");
  if (!undefined) return;
  const auto numbers = parse_reals(undefined->value("value"));
  const bool is_zero = numbers && std::all_of(numbers->begin(), numbers->end(),
                                              [](double number) { return number == 0; });
  if (is_zero) return;
  warnings.add(undefined->where,
               "'undefined' of the integrator 'field' is ignored: pixels without "
               "a surface are 0");
}

/// Returns "name:type" for `aov`; "" if it has no such variable.
std::string aov_of(const Node& field, size_t number, Warnings& warnings) {
  const std::string name = child_value(field, "field");
  const auto found = std::find_if(std::begin(kFields), std::end(kFields),
                                  [&](const auto& one) { return one.first == name; });
  if (found == std::end(kFields)) {
    warnings.add(field.where, fmt::format("unknown field '{}' is left out", name));
    return "";
  }
  if (name == "relPosition") {
    warnings.add(field.where, "the field 'relPosition' is replaced by the position in the world");
  }
  return fmt::format("{}{}:{}", name, number, found->second);
}

/// Replaces `multichannel` and its `field` integrators, or a single `field`, by `aov`.
void translate_channels(Node& node, Warnings& warnings) {
  std::string aovs;
  size_t count = 0;
  const auto add = [&](Node& field) {
    warn_of_undefined(field, warnings);
    const std::string one = aov_of(field, count++, warnings);
    if (one.empty()) return;
    if (!aovs.empty()) aovs += ',';
    aovs += one;
  };
  if (node.value("type") == "field") {
    add(node);
    node.children.clear();
  } else {
    std::erase_if(node.children, [&](Node& child) {
      const bool is_field = child.tag == "integrator" && child.value("type") == "field";
      if (is_field) add(child);
      return is_field;
    });
  }
  if (aovs.empty()) aovs = "depth:depth";
  set_type(node, "aov");
  add_value(node, "string", "aovs", aovs);
}

/// Replaces an integrator that only accelerates a nested one. Returns false if none is nested.
bool replace_by_nested(Node& node, Warnings& warnings) {
  const auto inner = std::find_if(node.children.begin(), node.children.end(),
                                  [](const Node& child) { return child.tag == "integrator"; });
  if (inner == node.children.end()) return false;
  warnings.add(node.where, fmt::format("'{}' is replaced by its nested integrator, which converges "
                                       "to the same image",
                                       node.value("type")));
  Node other = std::move(*inner);
  node = std::move(other);
  return true;
}

}  // namespace

void translate_integrator(Node& node, Warnings& warnings) {
  std::string type = node.value("type");
  while (type == "adaptive" || type == "errctrl" || type == "irrcache") {
    if (!replace_by_nested(node, warnings)) return set_type(node, "path");
    type = node.value("type");
  }
  rename_child(node, "luminaire_samples", "emitter_samples");
  if (type == "multichannel" || type == "field") return translate_channels(node, warnings);
  if (type == "volpath_simple") return set_type(node, "volpath");
  if (std::find(std::begin(kSameImage), std::end(kSameImage), type) == std::end(kSameImage)) return;
  warnings.add(node.where,
               fmt::format("'{}' is replaced by 'path', which converges to the same image", type));
  set_type(node, "path");
  keep_only(node, kKept);
}

void translate_ambient_occlusion(Node& scene, Warnings& warnings) {
  const auto ao = std::find_if(scene.children.begin(), scene.children.end(), [](const Node& child) {
    return child.is_old && child.tag == "integrator" && child.value("type") == "ao";
  });
  if (ao == scene.children.end()) return;
  const Location where = ao->where;
  warnings.add(where,
               "'ao' is replaced by direct light on white surfaces under a white sky; "
               "'ray_length' is ignored, and so are the scene's materials and emitters");
  set_type(*ao, "direct");
  ao->children.clear();
  add_value(*ao, "boolean", "hide_emitters", "true");
  const auto whiten = [&](auto&& self, Node& node) -> void {
    std::erase_if(node.children, [](const Node& child) { return child.tag == "emitter"; });
    const bool has_surface = node.tag == "shape" && node.value("type") != "instance" &&
                             node.value("type") != "shapegroup";
    if (has_surface) {
      std::erase_if(node.children, [](const Node& child) {
        return child.tag == "bsdf" || (child.tag == "ref" && !child.find("name"));
      });
      Node white = make_object("bsdf", "diffuse", where);
      add_number(white, "reflectance", 1);
      Node both_sides = make_object("bsdf", "twosided", where);
      both_sides.children.push_back(std::move(white));
      node.children.push_back(std::move(both_sides));
    }
    for (Node& child : node.children) self(self, child);
  };
  whiten(whiten, scene);
  scene.children.push_back(make_object("emitter", "constant", where));
}

}  // namespace kinome::loader::legacy
