#pragma once

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string>

#include "batch.h"
#include "kinome/measured_indices.h"

namespace kinome {

/// Values of `material`: "none", and the names of the presets. Some presets have a second name.
inline constexpr auto kConductorNames = [] {
  constexpr auto kSeconds = std::ranges::count_if(kMeasuredIndices, &MeasuredIndex::second_name);
  std::array<const char*, 1 + std::size(kMeasuredIndices) + kSeconds> names{"none"};
  size_t count = 1;
  for (const MeasuredIndex& preset : kMeasuredIndices) {
    names[count++] = preset.name;
    if (preset.second_name) names[count++] = preset.second_name;
  }
  return names;
}();

/// Complex index of refraction of a conductor: a preset, or eta and k.
class ConductorIndex {
 public:
  explicit ConductorIndex(const Properties& props) {
    const std::string material = props.string("material");
    if (material == "none") {
      eta_ = ColorInput(texture_of_any_sign(props, "eta"));
      k_ = ColorInput(texture_of_any_sign(props, "k"));
      return;
    }
    for (const char* name : {"eta", "k"}) props.exclude(name, "material");
    const MeasuredIndex& preset = *measured_index(kConductorNames[props.choice("material")]);
    eta_ = ColorInput(make_uniform_texture(preset.eta));
    k_ = ColorInput(make_uniform_texture(preset.k));
  }

  /// The textures. Callers must pass their values through bounded().
  const ColorInput& eta() const { return *eta_; }
  const ColorInput& k() const { return *k_; }

  /// Returns the absolute value of eta or k, clamped to 1e4. The sign doesn't matter, because the
  /// reflectance depends only on the squares of eta and k. The clamp keeps their fourth powers
  /// finite. It hardly changes the reflectance, which differs from 1 by only a few 1e-4 at 1e4.
  template <class V>
  static V bounded(const V& index) {
    using std::abs;
    constexpr float kMax = 1e4f;
    return {min(abs(index.x), NumberOf<V>(kMax)), min(abs(index.y), NumberOf<V>(kMax)),
            min(abs(index.z), NumberOf<V>(kMax))};
  }

 private:
  /// Reads eta or k. Values that were fitted to a measured colour may be negative.
  static std::shared_ptr<Texture> texture_of_any_sign(const Properties& props, const char* name) {
    auto texture = props.texture(name);
    if (texture->min() < 0) {
      props.warn(name,
                 "has negative values; their sign has no effect, because the reflectance depends "
                 "on the square");
    }
    return texture;
  }

  std::optional<ColorInput> eta_;
  std::optional<ColorInput> k_;
};

/// Parameters that ConductorIndex reads.
#define KINOME_CONDUCTOR_PARAMETERS                                                   \
  ::kinome::choice_of("material", ::kinome::kConductorNames, "none",                  \
                      "a preset such as Au, Ag, Cu, Al, Cr, W; none: use eta and k"), \
      {"eta", ::kinome::ParameterType::kUnitlessTexture, "0",                         \
       "real part of the index of refraction (eta = 0, k = 1: a perfect mirror)"},    \
  {                                                                                   \
    "k", ::kinome::ParameterType::kUnitlessTexture, "1",                              \
        "imaginary part of the index of refraction"                                   \
  }

}  // namespace kinome
