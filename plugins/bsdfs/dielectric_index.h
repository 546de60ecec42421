#pragma once

#include <cmath>
#include <string>

#include "kinome/properties.h"

namespace kinome {

/// Named indices of refraction, the same as Mitsuba's.
inline constexpr NamedNumber kIndicesOfRefraction[] = {
    {"vacuum", 1.f},       {"helium", 1.000036f},        {"hydrogen", 1.000132f},
    {"air", 1.000277f},    {"carbon dioxide", 1.00045f}, {"water", 1.333f},
    {"acetone", 1.36f},    {"ethanol", 1.361f},          {"carbon tetrachloride", 1.461f},
    {"glycerol", 1.4729f}, {"benzene", 1.501f},          {"silicone oil", 1.52045f},
    {"bromine", 1.661f},   {"water ice", 1.31f},         {"fused quartz", 1.458f},
    {"pyrex", 1.47f},      {"acrylic glass", 1.49f},     {"polypropylene", 1.49f},
    {"bk7", 1.5046f},      {"sodium chloride", 1.544f},  {"amber", 1.55f},
    {"pet", 1.575f},       {"diamond", 2.419f},
};

/// Parameters of dielectric boundaries, without roughness.
#define KINOME_SMOOTH_DIELECTRIC_PARAMETERS(inside, outside)                           \
  {"int_ior", ParameterType::kFloatOrName, "bk7", "index of refraction " inside},      \
      {"ext_ior", ParameterType::kFloatOrName, "air", "index of refraction " outside}, \
      {"specular_reflectance", ParameterType::kReflectanceTexture, "1",                \
       "scale factor of the reflection"},                                              \
  {                                                                                    \
    "specular_transmittance", ParameterType::kReflectanceTexture, "1",                 \
        "scale factor of the transmission"                                             \
  }

/// Returns int_ior / ext_ior. Both are bounded so that squares and inverses are finite.
inline float relative_ior(const Properties& props) {
  constexpr float kMin = 1e-3f, kMax = 1e3f;
  const auto index = [&](const char* name) {
    const float value = props.number_or_name(name, kIndicesOfRefraction);
    if (!(value > 0) || !std::isfinite(value)) {
      throw props.error(name, "must be positive, got " + format_number(value));
    }
    if (value < kMin || value > kMax) {
      throw props.error(name, "must be between 0.001 and 1000, got " + format_number(value));
    }
    return value;
  };
  return index("int_ior") / index("ext_ior");
}

/// Returns relative_ior() for rough boundaries, which must refract light: without refraction, the
/// half vectors of transmission are lost to rounding. Throws if it is within 1e-4 of 1.
inline float bending_ior(const Properties& props) {
  const float eta = relative_ior(props);
  if (std::abs(eta - 1) < 1e-4f) {
    throw props.error("int_ior",
                      "must differ from ext_ior by at least 0.01 %, got int_ior / "
                      "ext_ior = " +
                          format_number(eta));
  }
  return eta;
}

}  // namespace kinome
