#include "plugin/property_types.h"

#include <stdexcept>

#include "base/numbers.h"
#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/film.h"
#include "kinome/integrator.h"
#include "kinome/medium.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/sampler.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/texture.h"

namespace kinome {
namespace {

template <class T>
bool holds(const Properties::Value& value) {
  return std::holds_alternative<T>(value);
}

/// Returns "a bsdf", "an emitter" and so on.
std::string with_article(Category category) {
  const std::string name = to_string(category);
  return (name[0] == 'e' || name[0] == 'i' ? "an " : "a ") + name;
}

template <class T>
bool is_a(const Properties::Value& value) {
  const auto* object = std::get_if<std::shared_ptr<Object>>(&value);
  return object && dynamic_cast<const T*>(object->get());
}

std::optional<Properties::Value> parse_vector_default(ParameterType type, const char* text) {
  const auto v = parse_reals(text);
  if (!v || (v->size() != 1 && v->size() != 3)) return std::nullopt;
  const auto at = [&](size_t i) { return static_cast<float>((*v)[v->size() == 1 ? 0 : i]); };
  const Vec3 value(at(0), at(1), at(2));
  if (type == ParameterType::kVector) return value;
  return UniformColor{value, false, v->size() == 1};
}

std::optional<Properties::Value> parse_transform_default(const char* text) {
  const auto v = parse_reals(text);
  if (std::string_view(text) == "identity" || (v && v->empty())) return Transform();
  if (!v || v->size() != 16) return std::nullopt;
  Mat4 m;
  for (int i = 0; i < 16; ++i) m[i % 4][i / 4] = static_cast<float>((*v)[i]);
  return Transform(m);
}

}  // namespace

std::string describe(const Properties::Value& value) {
  struct Visitor {
    std::string operator()(bool) const { return "a boolean"; }
    std::string operator()(int64_t) const { return "an integer"; }
    std::string operator()(double) const { return "a float"; }
    std::string operator()(const std::string&) const { return "a string"; }
    std::string operator()(const Vec3&) const { return "a vector"; }
    std::string operator()(const UniformColor& c) const {
      return c.is_float ? "a float" : c.spectral ? "a spectrum" : "an rgb color";
    }
    std::string operator()(const Transform&) const { return "a transform"; }
    std::string operator()(const std::shared_ptr<const Image>&) const { return "pixels"; }
    std::string operator()(const std::shared_ptr<Object>& object) const {
      return with_article(category_of(*object));
    }
  };
  return std::visit(Visitor{}, value);
}

std::string describe(const Parameter& parameter) {
  return parameter.type == ParameterType::kObject ? with_article(parameter.category)
                                                  : describe(parameter.type);
}

bool accepts(ParameterType type, const Properties::Value& value) {
  if (type == ParameterType::kVolume && is_a<Volume>(value)) return true;
  if (takes_texture(type)) return is_a<Texture>(value) || as_uniform_color(value).has_value();
  switch (type) {
    case ParameterType::kBoolean:
      return holds<bool>(value);
    case ParameterType::kInteger:
      return holds<int64_t>(value);
    case ParameterType::kFloat:
      return holds<double>(value) || holds<int64_t>(value);
    case ParameterType::kFloatOrName:
      return holds<double>(value) || holds<int64_t>(value) || holds<std::string>(value);
    case ParameterType::kString:
    case ParameterType::kFile:
      return holds<std::string>(value);
    case ParameterType::kVector:
      return holds<Vec3>(value);
    case ParameterType::kTransform:
      return holds<Transform>(value);
    case ParameterType::kImage:
      return holds<std::shared_ptr<const Image>>(value);
    case ParameterType::kObject:
      return holds<std::shared_ptr<Object>>(value);
    default:
      return false;
  }
}

bool accepts(const Parameter& parameter, const Properties::Value& value) {
  const auto* object = std::get_if<std::shared_ptr<Object>>(&value);
  const bool is_of_category = !object || parameter.type != ParameterType::kObject ||
                              category_of(**object) == parameter.category;
  return is_of_category && accepts(parameter.type, value);
}

std::optional<UniformColor> as_uniform_color(const Properties::Value& value) {
  const auto grey = [](double v) { return UniformColor{Rgb(static_cast<float>(v)), false, true}; };
  if (const auto* color = std::get_if<UniformColor>(&value)) return *color;
  if (const auto* real = std::get_if<double>(&value)) return grey(*real);
  if (const auto* integer = std::get_if<int64_t>(&value))
    return grey(static_cast<double>(*integer));
  if (const auto* vector = std::get_if<Vec3>(&value)) return UniformColor{*vector, false, false};
  return std::nullopt;
}

Properties::Value parse_default(const Parameter& parameter) {
  const char* const text = parameter.default_value;
  const auto parse = [&]() -> std::optional<Properties::Value> {
    if (takes_texture(parameter.type)) return parse_vector_default(parameter.type, text);
    switch (parameter.type) {
      case ParameterType::kBoolean:
        return parse_boolean(text);
      case ParameterType::kInteger:
        return parse_integer(text);
      case ParameterType::kFloat:
        return parse_real(text);
      case ParameterType::kFloatOrName:
        if (const auto number = parse_real(text)) return *number;
        return std::string(text);
      case ParameterType::kString:
      case ParameterType::kFile:
        return std::string(text);
      case ParameterType::kVector:
        return parse_vector_default(parameter.type, text);
      case ParameterType::kTransform:
        return parse_transform_default(text);
      default:
        return std::nullopt;
    }
  };
  if (auto value = parse()) return *value;
  throw std::logic_error(std::string("default of parameter '") + parameter.name + "' is not " +
                         describe(parameter.type) + ": '" + text + "'");
}

Category category_of(const Object& object) {
  if (dynamic_cast<const Bsdf*>(&object)) return Category::kBsdf;
  if (dynamic_cast<const Emitter*>(&object)) return Category::kEmitter;
  if (dynamic_cast<const Film*>(&object)) return Category::kFilm;
  if (dynamic_cast<const Integrator*>(&object)) return Category::kIntegrator;
  if (dynamic_cast<const Medium*>(&object)) return Category::kMedium;
  if (dynamic_cast<const Phase*>(&object)) return Category::kPhase;
  if (dynamic_cast<const ReconstructionFilter*>(&object)) return Category::kReconstructionFilter;
  if (dynamic_cast<const Sampler*>(&object)) return Category::kSampler;
  if (dynamic_cast<const Sensor*>(&object)) return Category::kSensor;
  if (dynamic_cast<const Shape*>(&object)) return Category::kShape;
  if (dynamic_cast<const Texture*>(&object)) return Category::kTexture;
  if (dynamic_cast<const Volume*>(&object)) return Category::kVolume;
  throw std::logic_error("an object of no category");
}

}  // namespace kinome
