/// Parallel light from infinitely far, such as the sun's without its extent: `irradiance` on a
/// surface that faces it.
///
///     <emitter type="directional">
///       <vector name="direction" x="1" y="-2" z="0"/>
///       <rgb name="irradiance" value="3 2.9 2.5"/>
///     </emitter>

#include "distant_disk.h"
#include "emission.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"direction", ParameterType::kVector, nullptr, "Where the light goes; in place of to_world."},
    {"to_world", ParameterType::kTransform, "identity", "Turns +z to where the light goes."},
    {"irradiance", ParameterType::kColor, "1", "Flux per area across the direction [W/m²]."},
};

Vec3 read_direction(const Properties& props) {
  if (props.has("direction") && props.has("to_world")) {
    throw props.error("to_world", "can't be given together with direction");
  }
  const Vec3 v = props.has("direction") ? props.vector("direction")
                                        : props.transform("to_world").vector(Vec3(0, 0, 1));
  // Divided first, so that squares neither over- nor underflow.
  const float largest = max_component(glm::abs(v));
  if (!(largest > 0) || !is_finite(v)) {
    throw props.error("direction", "must be finite and not zero");
  }
  return glm::normalize(v / largest);
}

class DirectionalLight final : public Emitter {
 public:
  explicit DirectionalLight(const Properties& props)
      : direction_(read_direction(props)), irradiance_(read_emission(props, "irradiance")) {}

  void prepare(const Aabb& scene_bounds) override { disk_.prepare(scene_bounds); }

  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& /*u*/) const override {
    if (is_black(irradiance_)) return std::nullopt;
    return DirectSample{-direction_, kInfinity, 1, irradiance_, true};
  }

  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& /*direction*/) const override {
    if (is_black(irradiance_)) return std::nullopt;
    auto sample = disk_.sample(direction_, position);
    if (sample) sample->power = irradiance_ / sample->pdf_position;
    return sample;
  }

 private:
  Vec3 direction_;
  Rgb irradiance_;
  DistantDisk disk_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::DirectionalLight, kinome::Category::kEmitter, "directional",
              "Parallel light from infinitely far.", kinome::kTable);
