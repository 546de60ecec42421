#pragma once

#include <span>

#include "kinome/object.h"

namespace kinome {

/// Type of a plugin parameter.
enum class ParameterType {
  kBoolean,
  kInteger,
  kFloat,
  kString,
  kFloatOrName,  ///< a number, or the name of one: `int_ior` as 1.5046 or "bk7"
  kFile,         ///< a string with a file name, resolved against the search paths
  kVector,       ///< three numbers: <point> or <vector>
  kEmission,     ///< uniform emission: <rgb>, <spectrum>, <float> or a uniform texture
  /// A uniform value or a <texture> with this quantity (see Quantity).
  kEmissionTexture,
  kReflectanceTexture,
  kUnitlessTexture,
  kColorTexture,
  /// A <volume>, or a uniform value in place of one. Uniform colours must be in [0,1].
  kVolume,
  kTransform,
  kImage,   ///< pixels in memory (Properties::image()); not available in scene files
  kObject,  ///< a nested object of `category`; its name is arbitrary unless `by_name` is set
};
KINOME_EXPORT const char* to_string(ParameterType type);

/// Physical quantity of a colour or texture. It determines the conversion of a <spectrum> to linear
/// Rec.709, as in Mitsuba 3's RGB variants, and the valid range of uniform values. Spectra given by
/// wavelengths convert to non-negative colours: negative components of saturated spectra, outside
/// the RGB gamut, become 0.
enum class Quantity {
  kNone,         ///< neither colour nor texture
  kEmission,     ///< radiance, irradiance, intensity: unbounded; a constant spectrum of 1 is
                 ///< equal-energy light, (1.205, 0.948, 0.909)
  kReflectance,  ///< in [0,1]; spectra are viewed under D65, so that a constant 1 is white
  kUnitless,  ///< roughness, exponent, index of refraction: unbounded; spectra are viewed under D65
  kColor,     ///< values of textures usable for any of these: unbounded; spectra by wavelengths are
              ///< reflectances
};
KINOME_EXPORT Quantity quantity_of(ParameterType type);
/// True if a <texture> is a valid value (for kEmission, only a uniform one).
KINOME_EXPORT bool takes_texture(ParameterType type);

/// Row of a plugin's parameter table. The table generates the documentation, validates scenes, and
/// defines the defaults.
struct Parameter {
  const char* name;
  ParameterType type;
  /// Default as written in XML ("0.5", "1 0 0", "true"). nullptr: none; the parameter is required,
  /// or the plugin checks Properties::has().
  const char* default_value;
  const char* doc;
  bool required = false;
  Category category = Category::kBsdf;  ///< category of a kObject
  int max_count = 1;                    ///< maximum number of kObjects of this row
  /// Valid values of a kString (see Properties::choice()); empty: any string.
  std::span<const char* const> choices = {};
  /// True if scenes may give the parameter but the plugin never reads it. The loader still checks
  /// its type, and logs a warning with `doc` as the reason. See ignored_row().
  bool ignored = false;
  /// True for a kObject that scenes must give by the row's name. See named_object().
  bool by_name = false;
};

/// Creates a row for a string with a fixed set of values. `choices` must live as long as the
/// plugin.
constexpr Parameter choice_of(const char* name, std::span<const char* const> choices,
                              const char* default_value, const char* doc) {
  Parameter row{name, ParameterType::kString, default_value, doc};
  row.choices = choices;
  return row;
}

/// Creates a row for a nested object that scenes give by name: `<bsdf name="interior" type="…"/>`.
/// This lets a plugin distinguish objects of one category. See Properties::object(name).
constexpr Parameter named_object(const char* name, Category category, const char* doc,
                                 bool required = false) {
  Parameter row{name, ParameterType::kObject, nullptr, doc, required, category};
  row.by_name = true;
  return row;
}

/// Creates a row for a parameter that is accepted without effect. `why` completes the loader's
/// warning "'NAME' is ignored: WHY".
constexpr Parameter ignored_row(const char* name, ParameterType type, const char* why) {
  Parameter row{name, type, nullptr, why};
  row.ignored = true;
  return row;
}

}  // namespace kinome
