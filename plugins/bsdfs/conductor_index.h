#pragma once

#include <array>
#include <iterator>
#include <optional>
#include <string>

#include "batch.h"
#include "conductor_presets.h"
#include "kinome/log.h"

namespace kinome {

/// What `material` may be: none, or a preset.
inline constexpr auto kConductorNames = [] {
  std::array<const char*, std::size(kConductorPresets) + 1> names{"none"};
  for (size_t i = 1; i < names.size(); ++i) names[i] = kConductorPresets[i - 1].name;
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
    for (const char* name : {"eta", "k"}) {
      if (props.has(name)) {
        throw props.error(name, "excludes 'material': give either, not both");
      }
    }
    const ConductorPreset& preset = kConductorPresets[props.choice("material") - 1];
    eta_ = ColorInput(make_uniform_texture(preset.eta));
    k_ = ColorInput(make_uniform_texture(preset.k));
  }

  /// The textures, whose values are to go through bounded().
  const ColorInput& eta() const { return *eta_; }
  const ColorInput& k() const { return *k_; }

  /// The index that the reflectance is computed from, which depends on its parts' squares alone.
  /// Beyond the bound the reflectance is 1 to a few 1e-4; fourth powers must stay numbers.
  template <class V>
  static V bounded(const V& index) {
    using std::abs;
    constexpr float kMost = 1e4f;
    return {min(abs(index.x), NumberOf<V>(kMost)), min(abs(index.y), NumberOf<V>(kMost)),
            min(abs(index.z), NumberOf<V>(kMost))};
  }

 private:
  /// Reads a part of the index. Values that are fitted to a measured colour may be negative.
  static std::shared_ptr<Texture> texture_of_any_sign(const Properties& props, const char* name) {
    auto texture = props.texture(name);
    if (texture->min() < 0) {
      log_warn(props.error(name, "is negative in part, which has no effect: the reflectance depends "
                                 "on its square")
                   .what());
    }
    return texture;
  }

  std::optional<ColorInput> eta_;
  std::optional<ColorInput> k_;
};

/// The rows of a plugin's table that ConductorIndex reads.
#define KINOME_CONDUCTOR_PARAMETERS                                                    \
  ::kinome::choice_of("material", ::kinome::kConductorNames, "none",                   \
                      "a preset such as Au, Ag, Cu, Al, Cr, W; none: eta and k"),      \
      {"eta", ::kinome::ParameterType::kUnitlessTexture, "0",                          \
       "real part of the index of refraction (0 with k = 1: a perfect mirror)"},       \
  {                                                                                    \
    "k", ::kinome::ParameterType::kUnitlessTexture, "1", "imaginary part of the index" \
  }

}  // namespace kinome
