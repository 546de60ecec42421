#include "kinome/properties.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include <fmt/format.h>

#include "base/file_search.h"
#include "base/numbers.h"
#include "kinome/log.h"
#include "kinome/texture.h"
#include "kinome/volume.h"
#include "plugin/property_types.h"

namespace kinome {
namespace {

/// Mitsuba's equal-energy white in linear Rec.709: the colour of an emitter's uniform <spectrum>.
const Rgb kEqualEnergyWhite(1.204794f, 0.948291f, 0.908916f);

/// Returns `value` as a T. Throws Error if it has another type.
template <class T>
T get_as(const Properties& props, const std::string& name, const Properties::Value& value,
         const char* expected) {
  if (const T* typed = std::get_if<T>(&value)) return *typed;
  throw props.error(name, std::string("must be ") + expected + ", got " + describe(value));
}

std::shared_ptr<Texture> as_texture(const Properties::Value& value) {
  const auto* object = std::get_if<std::shared_ptr<Object>>(&value);
  return object ? std::dynamic_pointer_cast<Texture>(*object) : nullptr;
}

Rgb as_light(const UniformColor& color) {
  return color.spectral ? color.value * kEqualEnergyWhite : color.value;
}

std::string format_color(const UniformColor& c) {
  return c.is_float ? fmt::format("{}", c.value.x)
                    : fmt::format("{} {} {}", c.value.x, c.value.y, c.value.z);
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

Properties::Properties(Category category, std::string plugin_name, Location where)
    : category_(category), plugin_name_(std::move(plugin_name)), where_(std::move(where)) {}

void Properties::set(const std::string& name, Value value, const Location& where) {
  for (const auto& [other, entry] : entries_) {
    if (other != name) continue;
    throw Error(where, "'" + name + "' is given twice (first at " + to_string(entry.where) + ")");
  }
  entries_.emplace_back(name, Entry{std::move(value), where});
}

const Properties::Entry* Properties::find(const std::string& name) const {
  for (const auto& [key, entry] : entries_) {
    if (key == name) {
      entry.read = true;
      return &entry;
    }
  }
  return nullptr;
}

const Parameter& Properties::parameter(const std::string& name) const {
  for (const Parameter& row : table_) {
    if (name == row.name) return row;
  }
  throw std::logic_error("plugin '" + plugin_name_ + "' reads '" + name +
                         "', which is missing in its parameter table");
}

bool Properties::has(const std::string& name) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const auto& entry) { return entry.first == name; });
}

bool Properties::has_object(const std::string& name) const {
  return std::any_of(entries_.begin(), entries_.end(), [&](const auto& entry) {
    return entry.first == name &&
           std::holds_alternative<std::shared_ptr<Object>>(entry.second.value);
  });
}

Properties::Value Properties::value(const std::string& name) const {
  if (const Entry* entry = find(name)) return entry->value;
  const Parameter& row = parameter(name);
  if (row.default_value) return parse_default(row);
  if (row.type == ParameterType::kTransform) return Transform();
  throw Error(where_, std::string(to_string(category_)) + " '" + plugin_name_ +
                          "' needs parameter '" + name + "', " + describe(row));
}

bool Properties::boolean(const std::string& name) const {
  return get_as<bool>(*this, name, value(name), "a boolean");
}

int64_t Properties::integer(const std::string& name) const {
  return get_as<int64_t>(*this, name, value(name), "an integer");
}

uint32_t Properties::integer(const std::string& name, uint32_t low, uint32_t high) const {
  const int64_t value = integer(name);
  if (value < low || value > high) {
    throw error(name, "must be from " + std::to_string(low) + " to " + std::to_string(high) +
                          ", got " + std::to_string(value));
  }
  return static_cast<uint32_t>(value);
}

float Properties::real(const std::string& name) const {
  const Value v = value(name);
  if (const auto* integer = std::get_if<int64_t>(&v)) return static_cast<float>(*integer);
  return static_cast<float>(get_as<double>(*this, name, v, "a float"));
}

float Properties::number_or_name(const std::string& name,
                                 std::span<const NamedNumber> names) const {
  const Value v = value(name);
  const auto* wanted = std::get_if<std::string>(&v);
  if (!wanted) return real(name);
  std::vector<std::string> known;
  for (const NamedNumber& named : names) {
    if (lower_case(*wanted) == lower_case(named.name)) return named.value;
    known.emplace_back(named.name);
  }
  throw error(name, "must be a number or a known name, got '" + *wanted + "'" +
                        did_you_mean(nearest_name(*wanted, known)));
}

std::string Properties::string(const std::string& name) const {
  return get_as<std::string>(*this, name, value(name), "a string");
}

std::string Properties::file(const std::string& name) const {
  static const std::vector<std::string> kNowhere;
  const Error fault = error(name, "can't be found: ");
  return find_file(string(name), search_paths_ ? *search_paths_ : kNowhere, fault.where(),
                   fault.message());
}

Vec3 Properties::vector(const std::string& name) const {
  return get_as<Vec3>(*this, name, value(name), "a vector");
}

Rgb Properties::color(const std::string& name) const {
  const Value v = value(name);
  if (const auto texture = as_texture(v)) {
    if (!texture->is_uniform()) {
      throw error(name, "must be uniform, got a texture that varies");
    }
    return texture->emission();
  }
  const auto color = as_uniform_color(v);
  if (!color) throw error(name, "must be a color, got " + describe(v));
  return as_light(*color);
}

Transform Properties::transform(const std::string& name) const {
  const Transform transform = get_as<Transform>(*this, name, value(name), "a transform");
  // Most callers use the linear part and the origin, and would ignore the last row.
  const Mat4& m = transform.matrix();
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || !(m[3][3] != 0)) {
    throw error(name, "must be an affine transform, got a projective one");
  }
  return m[3][3] == 1 ? transform : Transform(m / m[3][3]);
}

std::shared_ptr<Texture> Properties::texture(const std::string& name) const {
  const Parameter& row = parameter(name);
  if (!has(name) && !row.default_value) return nullptr;
  const Value v = value(name);
  const Quantity quantity = quantity_of(row.type);
  if (const auto texture = as_texture(v)) {
    const bool is_light = quantity == Quantity::kEmission && texture->is_uniform();
    if (is_light && texture->emission() != texture->mean()) {
      return make_uniform_texture(texture->emission());
    }
    return texture;
  }
  const auto color = as_uniform_color(v);
  if (!color) throw error(name, "must be a texture, color or float, got " + describe(v));
  const Rgb& c = color->value;
  if (!is_finite(c)) throw error(name, "must be finite, got " + format_color(*color));
  const bool inside = max_component(c) <= 1 && max_component(-c) <= 0;
  if (quantity == Quantity::kReflectance && !inside) {
    throw error(name, "is outside [0,1]: " + format_color(*color));
  }
  return make_uniform_texture(quantity == Quantity::kEmission ? as_light(*color) : c);
}

std::shared_ptr<Volume> Properties::volume(const std::string& name) const {
  if (!has(name) && !parameter(name).default_value) return nullptr;
  const Value v = value(name);
  if (const auto* const object = std::get_if<std::shared_ptr<Object>>(&v)) {
    if (auto volume = std::dynamic_pointer_cast<Volume>(*object)) return volume;
    const auto texture = as_texture(v);
    if (!texture || !texture->is_uniform()) {
      throw error(name, "must be uniform, got a texture that varies");
    }
    return std::make_shared<UniformVolume>(texture->mean());
  }
  const auto color = as_uniform_color(v);
  if (!color) throw error(name, "must be a volume, color or float, got " + describe(v));
  const Rgb& c = color->value;
  if (!is_finite(c)) throw error(name, "must be finite, got " + format_color(*color));
  const bool is_unbounded = color->is_float || color->spectral;
  if (!is_unbounded && (max_component(c) > 1 || max_component(-c) > 0)) {
    throw error(name, "is outside [0,1]: " + format_color(*color) +
                          "; for other colors use <volume type=\"constvolume\">");
  }
  return std::make_shared<UniformVolume>(c);
}

std::shared_ptr<const Image> Properties::image(const std::string& name) const {
  const Entry* const entry = find(name);
  if (!entry) return nullptr;
  return get_as<std::shared_ptr<const Image>>(*this, name, entry->value, "an array of pixels");
}

std::shared_ptr<Object> Properties::named(const std::string& name) const {
  const Parameter& row = parameter(name);
  if (!row.required && !has(name)) return nullptr;
  const Value v = value(name);
  if (!accepts(row, v)) throw error(name, "must be " + describe(row) + ", got " + describe(v));
  return std::get<std::shared_ptr<Object>>(v);
}

int Properties::choice(const std::string& name) const {
  const std::span<const char* const> choices = parameter(name).choices;
  const std::string wanted = string(name);
  std::string list;
  for (size_t i = 0; i < choices.size(); ++i) {
    if (wanted == choices[i]) return static_cast<int>(i);
    list += (list.empty() ? "'" : ", '") + std::string(choices[i]) + "'";
  }
  constexpr size_t kMaxListed = 16;
  if (choices.size() > kMaxListed) list = std::to_string(choices.size()) + " names";
  throw error(name, "must be one of " + list + ", got '" + wanted + "'" +
                        did_you_mean(nearest_name(wanted, choices)));
}

Error Properties::error(const std::string& name, const std::string& message) const {
  for (const auto& [key, entry] : entries_) {
    if (key == name) return Error(entry.where, "'" + name + "' " + message);
  }
  return Error(where_, std::string(to_string(category_)) + " '" + plugin_name_ + "': '" + name +
                           "' " + message);
}

void Properties::warn(const std::string& name, const std::string& message) const {
  log_warn(error(name, message).what());
}

}  // namespace kinome
