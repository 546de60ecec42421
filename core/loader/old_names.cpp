// Names of Mitsuba 0.4 to 0.6.

#include "loader/old_names.h"

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
  std::string_view tag;
  std::string_view old_name;
  std::string_view new_name;
  std::string_view remark = {};  ///< a warning, where the picture may differ
};

constexpr Renaming kTags[] = {
    {"lookAt", "", "lookat"}, {"camera", "", "sensor"}, {"luminaire", "", "emitter"}};

constexpr std::string_view kSameLight = "finds the same light by another way";
constexpr Renaming kTypes[] = {
    {"film", "ldrfilm", "hdrfilm", "writes linear colours: --png also writes them as sRGB"},
    {"film", "tiledhdrfilm", "hdrfilm"},
    {"film", "mfilm", "hdrfilm", "writes a picture, not text"},
    {"sampler", "hammersley", "ldsampler"},
    {"texture", "ldrtexture", "bitmap"},
    {"texture", "exrtexture", "bitmap"},
    {"bsdf", "lambertian", "diffuse"},
    {"bsdf", "bump", "bumpmap"},
    {"bsdf", "roughdiffuse", "diffuse", "is smooth"},
    {"integrator", "volpath_simple", "volpath"},
    {"integrator", "bdpt", "path", kSameLight},
    {"integrator", "erpt", "path", kSameLight},
    {"integrator", "mlt", "path", kSameLight},
    {"integrator", "pssmlt", "path", kSameLight},
    {"integrator", "photonmapper", "path", kSameLight},
    {"integrator", "ppm", "path", kSameLight},
    {"integrator", "sppm", "path", kSameLight},
};

/// Parameters by their object's tag.
constexpr Renaming kParameters[] = {
    {"integrator", "luminaire_samples", "emitter_samples"},
    {"film", "high_quality_edges", "sample_border"},
};

/// Those that mean nothing any more, also by their object's tag.
constexpr std::pair<std::string_view, std::string_view> kDropped[] = {
    {"integrator", "strict_normals"},
    {"film", "banner"},
    {"film", "attach_log"},
    {"sampler", "scramble"},
    {"sampler", "dimension"},
    {"shape", "max_smooth_angle"},
    {"shape", "collapse"},
    {"shape", "srgb"},
    {"texture", "cache"},
    {"texture", "max_anisotropy"},
    {"emitter", "cache"},
    {"emitter", "gamma"},
    {"bsdf", "specular_sampling_weight"},
    {"bsdf", "ext_eta"},
    {"bsdf", "use_fast_approx"},
};

/// What is kept of an object whose plugin got a stand-in that knows no other parameters.
constexpr std::string_view kOfPaths[] = {"max_depth", "rr_depth", "hide_emitters"};
constexpr std::string_view kOfFilms[] = {"width",       "height",        "crop_offset_x",
                                         "crop_offset_y", "crop_width", "crop_height",
                                         "sample_border"};

void tell_dropped(const Node& child) {
  log_info(Error(child.where, fmt::format("'{}' of older versions means nothing any more, and is "
                                          "ignored",
                                          child.value("name")))
               .what());
}

template <class Names>
void keep_only(Node& node, const Names& names) {
  std::erase_if(node.children, [&](const Node& child) {
    if (kind_of(child) != TagKind::kValue) return false;
    if (std::find(std::begin(names), std::end(names), child.value("name")) != std::end(names)) {
      return false;
    }
    tell_dropped(child);
    return true;
  });
}

void rename_tag(Node& node) {
  for (const Renaming& one : kTags) {
    if (node.tag == one.tag) node.tag = one.new_name;
  }
}

void rename_type(Node& node) {
  Attribute* const type = node.find("type");
  if (!type) return;
  for (const Renaming& one : kTypes) {
    if (node.tag != one.tag || type->value != one.old_name) continue;
    if (!one.remark.empty()) {
      log_warn(Error(type->where, fmt::format("'{}' is no more: '{}' stands in, which {}",
                                              one.old_name, one.new_name, one.remark))
                   .what());
    }
    type->value = one.new_name;
    if (one.remark == kSameLight) keep_only(node, kOfPaths);
    if (one.tag == "film") keep_only(node, kOfFilms);
    return;
  }
}

/// Colours of a hexadecimal "#rrggbb", in [0,1].
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

/// <srgb>, <rgb> in hexadecimal, and <spectrum> of three numbers become <rgb>.
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
  auto color = parse_hex(value->value);
  if (node.tag == "spectrum") {
    if (has_three || color) node.tag = "rgb";
    if (!color) return;
  }
  if (!color && !is_encoded) return;
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

/// <blackbody name="…" temperature="5000K" scale="2"/>
void rename_blackbody(Node& node) {
  if (node.tag != "blackbody") return;
  Node light{"texture", {{"type", "blackbody", node.where}}, {}, node.where, nullptr};
  for (Attribute& attribute : node.attributes) {
    if (attribute.name == "temperature" && attribute.value.ends_with("K")) {
      attribute.value.pop_back();
    }
    if (attribute.name == "temperature" || attribute.name == "scale") {
      light.children.push_back({"float",
                                {{"name", attribute.name, attribute.where},
                                 {"value", attribute.value, attribute.where}},
                                {},
                                attribute.where,
                                nullptr});
    } else {
      light.attributes.push_back(attribute);
    }
  }
  node = std::move(light);
}

/// Bitmaps: the gamma of numbers is 1, and a mip map's filter is none of Mitsuba 3's.
void rename_in_bitmap(Node& node) {
  std::erase_if(node.children, [&](Node& child) {
    Attribute* const value = child.find("value");
    const std::string name = child.value("name");
    if (!value) return false;
    if (name == "filter_type" && (value->value == "trilinear" || value->value == "ewa")) {
      value->value = "bilinear";
    }
    if (name == "gamma") {
      if (parse_real(value->value) != 1.) {
        tell_dropped(child);
        return true;
      }
      child = Node{"boolean",
                   {{"name", "raw", child.where}, {"value", "true", child.where}},
                   {},
                   child.where,
                   nullptr};
    }
    return false;
  });
}

void rename_parameters(Node& node) {
  for (Node& child : node.children) {
    Attribute* const name = child.find("name");
    if (!name) continue;
    for (const Renaming& one : kParameters) {
      if (node.tag == one.tag && name->value == one.old_name) name->value = one.new_name;
    }
  }
  std::erase_if(node.children, [&](const Node& child) {
    const std::string name = child.value("name");
    const bool is_dropped =
        std::any_of(std::begin(kDropped), std::end(kDropped),
                    [&](const auto& one) { return node.tag == one.first && name == one.second; });
    if (is_dropped) tell_dropped(child);
    return is_dropped;
  });
}

/// mixturebsdf of any number of BSDFs: blendbsdf of the first and all others, and so on.
void rename_mixture(Node& node, Faults& faults) {
  if (node.tag != "bsdf" || node.value("type") != "mixturebsdf") return;
  const auto given =
      std::find_if(node.children.begin(), node.children.end(),
                   [](const Node& child) { return child.value("name") == "weights"; });
  const Location where = node.where;
  const auto weights =
      given == node.children.end() ? std::nullopt : parse_reals(given->value("value"));
  // Where it makes no sense, nothing more is to be said of it.
  const auto fail = [&](const std::string& message) {
    faults.add(where, message);
    node.children.clear();
    node.find("type")->value = "diffuse";
  };
  if (!weights) return fail("mixturebsdf needs 'weights', a list of numbers");
  node.children.erase(given);
  std::vector<Node> parts = std::move(node.children);
  double sum = 0;
  for (const double w : *weights) sum += w;
  if (weights->size() != parts.size() || parts.size() < 2 || std::abs(sum - 1) > 1e-3) {
    return fail("mixturebsdf needs as many weights as BSDFs, two at least, that add up to 1");
  }
  const auto blend = [&](Node first, Node second, double weight) {
    Node value{"float",
               {{"name", "weight", where}, {"value", fmt::format("{:.9g}", weight), where}},
               {},
               where,
               nullptr};
    return std::vector<Node>{std::move(value), std::move(first), std::move(second)};
  };
  Node rest = std::move(parts.back());
  double of_rest = weights->back();
  for (size_t i = parts.size() - 1; i-- > 0;) {
    const double both = of_rest + (*weights)[i];
    std::vector<Node> children =
        blend(std::move(parts[i]), std::move(rest), both > 0 ? of_rest / both : 0);
    of_rest = both;
    if (i == 0) {
      node.children = std::move(children);
      node.find("type")->value = "blendbsdf";
    } else {
      rest = Node{"bsdf", {{"type", "blendbsdf", where}}, std::move(children), where, nullptr};
    }
  }
}

}  // namespace

void rename_old(Node& node, Faults& faults) {
  rename_tag(node);
  rename_color(node, faults);
  rename_blackbody(node);
  rename_parameters(node);
  rename_type(node);
  rename_mixture(node, faults);
  if (node.tag == "texture" && node.value("type") == "bitmap") rename_in_bitmap(node);
}

}  // namespace kinome::loader
