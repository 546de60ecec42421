/// Parallel light from infinitely far, such as sunlight from a single direction. `irradiance` is
/// the irradiance of a surface that faces the light. If to_world scales +z, the irradiance is
/// multiplied by the scale, as in Mitsuba 3 on diffuse surfaces. (Its other BSDFs assume unit
/// directions, which a scale breaks.)
///
///     <emitter type="directional">
///       <vector name="direction" x="1" y="-2" z="0"/>
///       <rgb name="irradiance" value="3 2.9 2.5"/>
///     </emitter>

#include "kinome/distant_disk.h"
#include "emission.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"direction", ParameterType::kVector, nullptr,
     "Direction in which the light travels; alternative to to_world."},
    {"to_world", ParameterType::kTransform, "identity",
     "Maps +z to the direction in which the light travels."},
    {"irradiance", ParameterType::kEmission, "1",
     "Flux per area perpendicular to the direction [W/m²]."},
};

struct Direction {
  Vec3 d{0, 0, 1};   ///< unit
  float length = 1;  ///< length of +z after to_world
};

Direction read_direction(const Properties& props) {
  const bool is_given = has_in_place_of_to_world(props, "direction");
  const Vec3 v =
      is_given ? props.vector("direction") : props.transform("to_world").vector(Vec3(0, 0, 1));
  // Divided first, so that squares neither overflow nor underflow.
  const float max_abs = max_component(glm::abs(v));
  if (!(max_abs > 0) || !is_finite(v)) {
    throw props.error("direction", "must be finite and not zero");
  }
  const float length = glm::length(v / max_abs);
  return {v / max_abs / length, is_given ? 1 : max_abs * length};
}

Rgb read_irradiance(const Properties& props, float length) {
  const Rgb irradiance = read_emission(props, "irradiance");
  if (std::abs(length - 1) <= 1e-3f) return irradiance;
  if (!(max_component(irradiance) * length <= kMaxEmission)) {
    throw props.error("to_world", "must not scale the irradiance beyond 1e36");
  }
  props.warn("to_world", "scales +z: the irradiance is multiplied by " + format_number(length) +
                             ", as in Mitsuba 3 on diffuse surfaces (its other BSDFs give wrong "
                             "results then)");
  return irradiance * length;
}

class DirectionalLight final : public Emitter {
 public:
  explicit DirectionalLight(const Properties& props)
      : DirectionalLight(props, read_direction(props)) {}

  void prepare(const Aabb& scene_bounds) override { disk_.prepare(scene_bounds); }

  bool is_delta() const override { return true; }

  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& /*u*/) const override {
    if (is_black(irradiance_)) return std::nullopt;
    return DirectSample{-direction_, kInfinity, 1, irradiance_, true};
  }

  void sample_direct_block(const Columns3& /*p*/, const Columns2& /*u*/, size_t count,
                           const DirectBlock& out) const override {
    const bool shines = !is_black(irradiance_);
    wide::for_lanes(count, [&](size_t i) {
      wide::Vec3(-direction_).store(out.d, i);
      wide::Float(kInfinity).store(out.distance + i);
      wide::Float(shines ? 1.f : 0.f).store(out.pdf + i);
      wide::Rgb(irradiance_).store(out.radiance, i);
      wide::Float(shines ? 1.f : 0.f).store(out.is_delta + i);
    });
  }

  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& /*direction*/) const override {
    if (is_black(irradiance_)) return std::nullopt;
    auto sample = disk_.sample(direction_, position);
    if (sample) sample->power = irradiance_ / sample->pdf_position;
    return sample;
  }
  void sample_emission_block(const Columns2& position, const Columns2& /*direction*/, size_t count,
                             const EmissionBlock& out) const override {
    const wide::Vec3 d = direction_;
    const wide::Rgb power = disk_.pdf() > 0 ? irradiance_ / disk_.pdf() : Rgb(0.f);
    wide::for_lanes(count, [&](size_t i) {
      disk_.origin(d, wide::Vec2::load(position, i)).store(out.o, i);
      d.store(out.d, i);
      power.store(out.power, i);
    });
  }

  std::optional<EmissionDensity> emission_density(const Vec3& /*d*/) const override {
    return EmissionDensity{0, disk_.pdf()};
  }

 private:
  DirectionalLight(const Properties& props, const Direction& direction)
      : direction_(direction.d), irradiance_(read_irradiance(props, direction.length)) {}

  Vec3 direction_;
  Rgb irradiance_;
  DistantDisk disk_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::DirectionalLight, kinome::Category::kEmitter, "directional",
              "Parallel light from infinitely far.", kinome::kTable);
