#include "scene_xml/values/convert.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/file_search.h"
#include "base/numbers.h"
#include "kinome/log.h"
#include "kinome/spectrum.h"

namespace kinome::loader {
namespace {

template <class T>
T or_error(const std::optional<T>& value, const Attribute& attribute, const char* what) {
  if (value) return *value;
  throw Error(attribute.where, "'" + attribute.value + "' is not " + what);
}

/// Clamps a reflectance to [0,1], as Mitsuba 3 does. Warns, because the spectrum may be meant as
/// emission.
Rgb clamped(const Rgb& color, const Attribute& attribute) {
  constexpr float kRounding = 1e-3f;
  if (max_component(color) > 1 + kRounding) {
    log_warn(Error(attribute.where,
                   fmt::format("this spectrum is a reflectance: its colour {:.4g} {:.4g} {:.4g} is "
                               "clamped to [0,1]",
                               color.x, color.y, color.z))
                 .what());
  }
  return glm::min(color, Rgb(1.f));
}

UniformColor convert_wavelengths(const Spectrum& spectrum, const Parameter* parameter,
                                 const Attribute& attribute) {
  switch (parameter ? quantity_of(parameter->type) : Quantity::kNone) {
    case Quantity::kEmission:
      return {emission_color(spectrum)};
    case Quantity::kReflectance:
    case Quantity::kColor:
      return {clamped(reflectance_color(spectrum), attribute)};
    case Quantity::kUnitless:
    case Quantity::kNone:  // an error, reported when the object's parameters are checked
      break;
  }
  return {reflectance_color(spectrum)};
}

UniformColor convert_spectrum(const Node& node, const Parameter* parameter,
                              const std::vector<std::string>& folders) {
  const Attribute* value = node.find("value");
  const Attribute* filename = node.find("filename");
  if (!value == !filename) {
    throw Error(node.where, "<spectrum> needs one of the attributes 'value' and 'filename'");
  }
  const Attribute& attribute = value ? *value : *filename;
  if (filename) {
    const std::string path = find_file(filename->value, folders, filename->where);
    const std::string text = read_text(path, filename->where);
    try {
      return convert_wavelengths(parse_spectrum_file(text, path), parameter, attribute);
    } catch (const Error& error) {
      throw error.requested_by(filename->where);
    }
  }
  if (value->value.find(':') != std::string::npos) {
    try {
      return convert_wavelengths(parse_spectrum(value->value), parameter, attribute);
    } catch (const Error& error) {
      throw Error(value->where, error.message());
    }
  }
  const double constant =
      or_error(parse_real(value->value), *value, "a number or a list of 'wavelength:value'");
  return {Rgb(static_cast<float>(constant)), true, false};
}

}  // namespace

Vec3 convert_triple(const Node& node, const Attribute& attribute) {
  const auto numbers = parse_reals(attribute.value);
  if (!numbers || (numbers->size() != 1 && numbers->size() != 3)) {
    throw Error(attribute.where,
                quoted_tag(node) + " needs one or three numbers, got '" + attribute.value + "'");
  }
  const auto at = [&](size_t i) {
    return static_cast<float>((*numbers)[numbers->size() == 1 ? 0 : i]);
  };
  return {at(0), at(1), at(2)};
}

Vec3 convert_vector(const Node& node, const float* missing) {
  const Attribute* const axes[] = {node.find("x"), node.find("y"), node.find("z")};
  if (const Attribute* value = node.find("value")) {
    for (const Attribute* axis : axes) {
      if (!axis) continue;
      throw Error(axis->where, "'" + axis->name + "' can't be combined with 'value'");
    }
    return convert_triple(node, *value);
  }
  Vec3 result(missing ? *missing : 0.f);
  for (int i = 0; i < 3; ++i) {
    if (axes[i]) {
      result[i] = static_cast<float>(or_error(parse_real(axes[i]->value), *axes[i], "a number"));
    } else if (!missing) {
      throw Error(node.where, quoted_tag(node) + " needs an attribute 'value', or all of x, y, z");
    }
  }
  return result;
}

Properties::Value convert(const Node& node, const Parameter* parameter,
                          const std::vector<std::string>& folders) {
  if (node.tag == "transform") return convert_transform(node);
  if (node.tag == "spectrum") return convert_spectrum(node, parameter, folders);
  if (node.tag == "point" || node.tag == "vector") return convert_vector(node, nullptr);
  const Attribute& value = *node.find("value");
  if (node.tag == "float") return or_error(parse_real(value.value), value, "a number");
  if (node.tag == "integer") return or_error(parse_integer(value.value), value, "an integer");
  if (node.tag == "boolean") return or_error(parse_boolean(value.value), value, "true or false");
  if (node.tag == "rgb") return UniformColor{convert_triple(node, value), false, false};
  return value.value;  // a string
}

}  // namespace kinome::loader
