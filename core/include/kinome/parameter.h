#pragma once

#include <span>

#include "kinome/object.h"

namespace kinome {

enum class ParameterType {
  kBoolean,
  kInteger,
  kFloat,
  kString,
  kFloatOrName,  ///< a number, or a string that stands for one: `int_ior` as 1.5046 or "bk7"
  kFile,         ///< a string that names a file; resolved against the search paths
  kVector,       ///< three numbers: <point> or <vector>
  kEmission,     ///< <rgb>, <spectrum>, <float> or a uniform texture: light, the same everywhere
  /// The same, or a <texture>; what it is of is in the name: see Quantity.
  kEmissionTexture,
  kReflectanceTexture,
  kUnitlessTexture,
  kColorTexture,
  kTransform,
  kImage,   ///< pixels in memory, which no scene file can hold: see Properties::image
  kObject,  ///< a nested object of `category`, whatever name it has
};
KINOME_EXPORT const char* to_string(ParameterType type);

/// What the numbers of a colour or texture measure. It decides what a <spectrum> comes to in linear
/// Rec.709, as in Mitsuba 3's RGB variants, and what uniform values a scene may give. A spectrum by
/// wavelengths never comes to less than 0: saturated ones lie outside of what RGB can show.
enum class Quantity {
  kNone,      ///< neither colour nor texture
  kEmission,  ///< radiance, irradiance, intensity: unbounded; a constant spectrum of 1 is light of
              ///< equal energy, (1.205, 0.948, 0.909)
  kReflectance,  ///< in [0,1]; a spectrum is seen under daylight (D65), a constant 1 is white
  kUnitless,     ///< roughness, exponent, index of refraction: unbounded; a spectrum as under D65
  kColor,        ///< of a texture that may serve for any of these: unbounded, but a spectrum by
                 ///< wavelengths is a reflectance
};
KINOME_EXPORT Quantity quantity_of(ParameterType type);
/// Whether a <texture> may be the value; of a kEmission a uniform one.
KINOME_EXPORT bool takes_texture(ParameterType type);

/// One row of a plugin's parameter table: it generates the documentation, checks the scene, and
/// holds the one and only default.
struct Parameter {
  const char* name;
  ParameterType type;
  /// As it would be written in XML ("0.5", "1 0 0", "true"). nullptr: no default; the plugin asks
  /// has() first, or the parameter is required.
  const char* default_value;
  const char* doc;
  bool required = false;
  Category category = Category::kBsdf;  ///< of a kObject
  int max_count = 1;                    ///< of a kObject
  /// Of a kString: all that it may be (Properties::choice); empty: any string.
  std::span<const char* const> choices = {};
  /// True if scenes may give the parameter but the plugin never reads it. The loader still checks
  /// its type, and logs a warning with `doc` as the reason. See ignored_row().
  bool ignored = false;
};

/// A row for a string that is one of some names, which must live as long as the plugin.
constexpr Parameter choice_of(const char* name, std::span<const char* const> choices,
                              const char* default_value, const char* doc) {
  Parameter row{name, ParameterType::kString, default_value, doc};
  row.choices = choices;
  return row;
}

/// A row for a parameter that is accepted without effect. `why` completes the loader's warning
/// "'NAME' is ignored: WHY".
constexpr Parameter ignored_row(const char* name, ParameterType type, const char* why) {
  Parameter row{name, type, nullptr, why};
  row.ignored = true;
  return row;
}

}  // namespace kinome
