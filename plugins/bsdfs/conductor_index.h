#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batch.h"
#include "conductor_presets.h"

namespace kinome {

/// Complex index of refraction of a conductor: a preset, or eta and k.
class ConductorIndex {
 public:
  explicit ConductorIndex(const Properties& props) {
    const std::string material = props.string("material");
    if (material == "none") {
      eta_ = ColorInput(nonnegative_texture(props, "eta"));
      k_ = ColorInput(nonnegative_texture(props, "k"));
      return;
    }
    for (const char* name : {"eta", "k"}) {
      if (props.has(name)) {
        throw props.error(name, "excludes 'material': give either, not both");
      }
    }
    std::vector<std::string> names{"none"};
    for (const ConductorPreset& preset : kConductorPresets) {
      if (material == preset.name) {
        eta_ = ColorInput(make_uniform_texture(preset.eta));
        k_ = ColorInput(make_uniform_texture(preset.k));
        return;
      }
      names.emplace_back(preset.name);
    }
    const std::string nearest = nearest_name(material, names);
    throw props.error("material",
                      "must be the name of a known conductor, got '" + material + "'" +
                          (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
  }

  /// The textures, whose values are to go through bounded().
  const ColorInput& eta() const { return *eta_; }
  const ColorInput& k() const { return *k_; }

  /// The index that is reckoned with. Beyond the bound the reflectance is 1 to a few 1e-4; fourth
  /// powers must stay numbers.
  template <class V>
  static V bounded(const V& index) {
    constexpr float kMost = 1e4f;
    return {min(index.x, NumberOf<V>(kMost)), min(index.y, NumberOf<V>(kMost)),
            min(index.z, NumberOf<V>(kMost))};
  }

 private:
  std::optional<ColorInput> eta_;
  std::optional<ColorInput> k_;
};

/// The rows of a plugin's table that ConductorIndex reads.
#define KINOME_CONDUCTOR_PARAMETERS                                                     \
  {"material", ::kinome::ParameterType::kString, "none",                                \
   "a preset such as Au, Ag, Cu, Al, Cr, W; none: eta and k"},                          \
      {"eta", ::kinome::ParameterType::kUnitlessTexture, "0",                          \
       "real part of the index of refraction (0 with k = 1: a perfect mirror)"},        \
  {                                                                                     \
    "k", ::kinome::ParameterType::kUnitlessTexture, "1", "imaginary part of the index" \
  }

}  // namespace kinome
