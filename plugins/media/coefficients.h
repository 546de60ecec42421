#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "kinome/medium.h"
#include "kinome/properties.h"

/// Parameters that media share.
namespace kinome {

#define KINOME_MEDIUM_PARAMETERS                                                               \
  {"albedo", ParameterType::kVolume, "0.75",                                                   \
   "scattered fraction of the light that the medium attenuates, in [0,1]"},                    \
      {"sigma_t", ParameterType::kVolume, "1",                                                 \
       "extinction: fraction of the light that is absorbed or scattered, per unit of length"}, \
      {"scale", ParameterType::kFloat, "1", "factor of sigma_t"},                              \
      {"phase", ParameterType::kObject, nullptr, "phase function; default: isotropic",         \
       false,   Category::kPhase},                                                             \
      {"sample_emitters", ParameterType::kBoolean, "true",                                     \
       "sample emitters where light scatters; false is better for dense media in glass"},      \
      ignored_row("has_spectral_extinction", ParameterType::kBoolean,                          \
                  "the colors of sigma_t decide")

/// Reads a volume whose values must be in [0, max].
inline std::shared_ptr<const Volume> volume_up_to(const Properties& props, const char* name,
                                                  float max) {
  auto volume = props.volume(name);
  if (volume->channels() > 3) throw props.error(name, "must have 1 or 3 channels, got 6");
  if (!(volume->min() >= 0)) {
    throw props.error(name, "must not be negative, got " + std::to_string(volume->min()));
  }
  if (!(volume->max() <= max)) {
    throw props.error(name, "must be " +
                                (std::isfinite(max) ? "at most " + std::to_string(max) : "finite") +
                                ", got " + std::to_string(volume->max()));
  }
  return volume;
}

/// Reads the phase function, which the loader adds if the scene has none.
inline std::shared_ptr<const Phase> phase_of(const Properties& props) {
  auto phase = props.object<Phase>();
  if (!phase) throw props.error("phase", "is missing: the medium needs a nested <phase>");
  return phase;
}

inline float extinction_scale(const Properties& props) {
  return props.real("scale", "must not be negative",
                    [](float scale) { return scale >= 0 && std::isfinite(scale); });
}

}  // namespace kinome
