#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "kinome/medium.h"
#include "kinome/properties.h"
#include "kinome/value_source.h"

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

/// Reads a volume of numbers or colours that must be finite and not negative.
inline std::shared_ptr<const Volume> nonnegative_volume(const Properties& props, const char* name) {
  auto volume = props.volume(name);
  if (volume->channels() > 3) throw props.error(name, "must have 1 or 3 channels, got 6");
  if (!(volume->min() >= 0)) {
    throw props.error(name, "must not be negative, got " + describe_min(*volume));
  }
  if (!std::isfinite(volume->max())) throw props.error(name, "must be finite");
  return volume;
}

/// Reads the albedo, which must be in [0,1].
inline std::shared_ptr<const Volume> albedo_volume(const Properties& props) {
  constexpr float kRounding = 1e-5f;  // of Volume::max()
  auto volume = nonnegative_volume(props, "albedo");
  if (volume->max() <= 1 + kRounding) return volume;
  throw props.error("albedo", "must be at most 1, got " + describe_max(*volume));
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
