// BSDFs of Mitsuba 0.x.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/numbers.h"
#include "scene_xml/legacy/legacy.h"

namespace kinome::loader::legacy {
namespace {

struct Renaming {
  std::string_view old_name;
  const char* new_name;
};
constexpr Renaming kTypes[] = {{"lambertian", "diffuse"},        {"bump", "bumpmap"},
                               {"roughmetal", "roughconductor"}, {"roughglass", "roughdielectric"},
                               {"microfacet", "roughplastic"},   {"composite", "mixturebsdf"}};
constexpr Renaming kParameters[] = {
    {"alpha_b", "alpha"}, {"alpha_x", "alpha_u"}, {"alpha_y", "alpha_v"}, {"ior", "eta"}};

bool is_any_of(const std::string& type, std::initializer_list<std::string_view> types) {
  return std::find(types.begin(), types.end(), type) != types.end();
}

/// Mitsuba 0.6 scales reflectances above 1 down to 0.99.
void limit_reflectance(Node& child, Warnings& warnings) {
  constexpr double kLimit = 0.99;
  const std::string name = child.value("name");
  const bool is_color = child.tag == "rgb" || child.tag == "float" || child.tag == "spectrum";
  const bool is_reflectance =
      name.find("reflectance") != name.npos || name.find("transmittance") != name.npos;
  Attribute* const value = child.find("value");
  if (!is_color || !is_reflectance || !value) return;
  auto numbers = parse_reals(value->value);
  if (!numbers || numbers->empty()) return;
  const double largest = *std::max_element(numbers->begin(), numbers->end());
  if (!(largest > 1) || !std::isfinite(largest)) return;
  warnings.add(child.where,
               fmt::format("'{}' is scaled to a maximum of 0.99, because it exceeds 1", name));
  value->value.clear();
  for (const double n : *numbers) {
    value->value += fmt::format("{}{:.9g}", value->value.empty() ? "" : " ", n * kLimit / largest);
  }
}

/// Replaces microfacet distributions that Mitsuba 3 doesn't have. Their alpha is comparable with
/// Beckmann's.
void translate_distribution(Node& node, Warnings& warnings) {
  Node* const distribution = find_child(node, "distribution");
  Attribute* const value = distribution ? distribution->find("value") : nullptr;
  if (!value || (value->value != "phong" && value->value != "as")) return;
  warnings.add(distribution->where,
               fmt::format("the distribution '{}' is replaced by 'beckmann' of the same alpha",
                           value->value));
  value->value = "beckmann";
}

/// Makes metals copper unless the scene says otherwise; in Mitsuba 3 they are perfect mirrors.
void add_metal(Node& node) {
  for (const char* name : {"material", "eta", "k"}) {
    if (find_child(node, name)) return;
  }
  add_value(node, "string", "material", "Cu");
}

/// Replaces the roughness along each axis by their mean.
void average_alpha(Node& node, Warnings& warnings) {
  const auto u = parse_real(child_value(node, "alpha_u"));
  const auto v = parse_real(child_value(node, "alpha_v"));
  if (!u || !v || find_child(node, "alpha")) return;
  if (*u != *v) {
    warnings.add(node.where, fmt::format("'alphaU' and 'alphaV' of '{}' are replaced by their mean",
                                         node.value("type")));
  }
  for (const char* name : {"alpha_u", "alpha_v"}) remove_children(node, name);
  add_number(node, "alpha", (*u + *v) / 2);
}

/// Replaces a texture of the roughness, which must be the same everywhere.
void drop_alpha_texture(Node& node, Warnings& warnings) {
  const Node* const alpha = find_child(node, "alpha");
  if (!alpha || (alpha->tag != "texture" && alpha->tag != "ref")) return;
  warnings.add(alpha->where,
               fmt::format("the texture 'alpha' of '{}' is replaced by 0.1", node.value("type")));
  remove_children(node, "alpha");
}

/// Replaces a diffuse transmitter by `principledthin`. `share` is its diff_trans: 2 if all light
/// goes through, 1 if half of it does.
void translate_translucent(Node& node, double share, Warnings& warnings) {
  const std::string type = node.value("type");
  rename_child(node, type == "hk" ? "albedo" : "transmittance", "base_color");
  auto color = take_child(node, "base_color");
  node.children.clear();
  if (color) node.children.push_back(std::move(*color));
  add_number(node, "diff_trans", share);
  if (type == "hk") {
    warnings.add(node.where,
                 "'hk' is replaced by a diffuse sheet that transmits half of the light; "
                 "its thickness and its coefficients are ignored");
  }
  set_type(node, "principledthin");
}

/// Translates a mixturebsdf to nested blendbsdfs: of the first BSDF and all others, and so on.
class Mixture {
 public:
  Mixture(Node& node, Warnings& warnings, Faults& faults)
      : node_(node), where_(node.where), warnings_(warnings), faults_(faults) {}

  void translate() {
    const auto given = take_child(node_, "weights");
    std::string text = given ? given->value("value") : "";
    std::replace(text.begin(), text.end(), ';', ',');
    auto weights = given ? parse_reals(text) : std::nullopt;
    if (!weights) return fail("mixturebsdf needs 'weights', a list of numbers");
    std::vector<Node> parts;
    for (Node& child : node_.children) {
      if (child.tag == "bsdf" || child.tag == "ref") parts.push_back(std::move(child));
    }
    if (weights->size() != parts.size() || parts.empty()) {
      return fail("mixturebsdf needs as many weights as BSDFs, and at least one");
    }
    if (!normalize(*weights, parts)) return;
    blend(*weights, std::move(parts));
  }

 private:
  /// Reports an error, and leaves a node that causes no further ones.
  void fail(const std::string& message) {
    faults_.add(where_, message);
    node_.children.clear();
    set_type(node_, "diffuse");
  }

  /// Scales weights whose sum exceeds 1, and adds a black BSDF if it is less than 1.
  bool normalize(std::vector<double>& weights, std::vector<Node>& parts) {
    constexpr double kRounding = 1e-6;
    double sum = 0;
    for (const double w : weights) sum += w;
    const bool is_negative =
        std::any_of(weights.begin(), weights.end(), [](double w) { return w < 0; });
    if (!(sum > 0) || !std::isfinite(sum) || is_negative) {
      fail("the weights of mixturebsdf must not be negative, and one must be positive");
      return false;
    }
    if (sum > 1 + kRounding) {
      warnings_.add(where_, fmt::format("the weights of mixturebsdf add up to {:.4g}, and are "
                                        "scaled to add up to 1",
                                        sum));
      for (double& w : weights) w /= sum;
    }
    if (sum < 1 - kRounding || parts.size() == 1) {
      Node black = make_object("bsdf", "diffuse", where_);
      add_number(black, "reflectance", 0);
      parts.push_back(std::move(black));
      weights.push_back(std::max(0., 1 - sum));
    }
    return true;
  }

  void blend(const std::vector<double>& weights, std::vector<Node> parts) {
    Node rest = std::move(parts.back());
    double weight_of_rest = weights.back();
    for (size_t i = parts.size() - 1; i-- > 0;) {
      const double sum = weight_of_rest + weights[i];
      Node both = make_object("bsdf", "blendbsdf", where_);
      add_number(both, "weight", sum > 0 ? weight_of_rest / sum : 0);
      both.children.push_back(std::move(parts[i]));
      both.children.push_back(std::move(rest));
      rest = std::move(both);
      weight_of_rest = sum;
    }
    set_type(node_, "blendbsdf");
    node_.children = std::move(rest.children);
  }

  Node& node_;
  Location where_;
  Warnings& warnings_;
  Faults& faults_;
};

void rename_parameters(Node& node, const std::string& type) {
  for (const Renaming& one : kParameters) rename_child(node, one.old_name, one.new_name);
  if (type == "diffuse" || type == "roughdiffuse") {
    rename_child(node, "diffuse_reflectance", "reflectance");
  }
  if (type != "normalmap") return;
  for (Node& child : node.children) {
    const bool is_map = child.tag == "texture" && !child.find("name");
    if (is_map) child.attributes.push_back({"name", "normalmap", child.where});
  }
}

}  // namespace

void translate_bsdf(Node& node, Warnings& warnings, Faults& faults) {
  std::string type = node.value("type");
  if (type == "microfacet") rename_child(node, "albedo", "diffuse_reflectance");
  for (const Renaming& one : kTypes) {
    if (type == one.old_name) set_type(node, type = one.new_name);
  }
  if (type == "mirror") {
    set_type(node, type = "conductor");
    add_value(node, "string", "material", "Cr");
  }
  rename_parameters(node, type);
  for (Node& child : node.children) limit_reflectance(child, warnings);
  translate_distribution(node, warnings);
  if (is_any_of(type, {"conductor", "roughconductor"})) add_metal(node);
  if (is_any_of(type, {"roughplastic", "roughcoating"})) {
    average_alpha(node, warnings);
    drop_alpha_texture(node, warnings);
  }
  if (type == "difftrans") translate_translucent(node, 2, warnings);
  if (type == "hk") translate_translucent(node, 1, warnings);
  if (type == "mixturebsdf") Mixture(node, warnings, faults).translate();
}

}  // namespace kinome::loader::legacy
