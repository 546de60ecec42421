/// A point that emits the same intensity in all directions. The irradiance of a surface that faces
/// it is intensity / distance².
///
///     <emitter type="point">
///       <point name="position" x="0" y="2" z="1"/>
///       <rgb name="intensity" value="10 9 8"/>
///     </emitter>

#include "emission.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"position", ParameterType::kVector, nullptr, "Position; alternative to to_world."},
    {"to_world", ParameterType::kTransform, "identity", "Maps the origin to the position."},
    {"intensity", ParameterType::kEmission, "1", "Flux per solid angle [W/sr]."},
};

Vec3 read_position(const Properties& props) {
  return has_in_place_of_to_world(props, "position") ? props.vector("position")
                                                     : props.transform("to_world").point(Vec3(0.f));
}

class PointLight final : public Emitter {
 public:
  explicit PointLight(const Properties& props)
      : position_(read_position(props)), intensity_(read_emission(props, "intensity")) {
    if (!is_finite(position_)) throw props.error("position", "must be finite");
  }

  bool is_delta() const override { return true; }

  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& /*u*/) const override {
    return light_from_point(TowardLight(p, position_), intensity_);
  }
  void sample_direct_block(const Columns3& p, const Columns2& /*u*/, size_t count,
                           const DirectBlock& out) const override {
    wide::for_lanes(count, [&](size_t i) {
      const TowardLight light(wide::Vec3::load(p, i), wide::Vec3(position_));
      store_light_from_point(out, i, light, intensity_);
    });
  }

  std::optional<EmissionSample> sample_emission(const Vec2& /*position*/,
                                                const Vec2& direction) const override {
    if (is_black(intensity_)) return std::nullopt;
    EmissionSample sample;
    sample.o = position_;
    sample.d = square_to_uniform_sphere(direction);
    sample.pdf_direction = kUniformSpherePdf;
    sample.power = intensity_ / kUniformSpherePdf;
    return sample;
  }
  void sample_emission_block(const Columns2& /*position*/, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const override {
    const wide::Rgb power = intensity_ / kUniformSpherePdf;
    wide::for_lanes(count, [&](size_t i) {
      const auto d = warp::square_to_uniform_sphere<wide::Vec3>(wide::Vec2::load(direction, i));
      store_emission(out, i, position_, d, true, power);
    });
  }

  std::optional<EmissionDensity> emission_density(const Vec3& /*d*/) const override {
    return EmissionDensity{kUniformSpherePdf, 0};
  }

 private:
  Vec3 position_;
  Rgb intensity_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::PointLight, kinome::Category::kEmitter, "point",
              "A point that emits light equally in all directions.", kinome::kTable);
