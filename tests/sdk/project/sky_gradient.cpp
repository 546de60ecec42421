// A sky that fades from the zenith (+y) to the horizon. Below the horizon it is constant.
//
//     L(d) = horizon + (zenith - horizon) max(d.y, 0)
//
//     <emitter type="sky_gradient"> <rgb name="zenith" value=".1 .3 .9"/> </emitter>

#include <algorithm>
#include <cmath>

#include <kinome/clustered_light.h>
#include <kinome/emitter.h>
#include <kinome/plugin.h>
#include <kinome/sphere_partition.h>

namespace {

using namespace kinome;

// One table for documentation, checks and defaults: `kinome plugins sky_gradient` prints it.
constexpr Parameter kParameters[] = {
    {"zenith", ParameterType::kEmission, "0.2 0.4 1", "Radiance straight up."},
    {"horizon", ParameterType::kEmission, "1", "Radiance at the horizon and below it."},
    {"scale", ParameterType::kFloat, "1", "Factor of both; not negative."},
};

class SkyGradient final : public Emitter, public ClusteredLight {
 public:
  explicit SkyGradient(const Properties& props)
      : zenith_(props.color("zenith")), horizon_(props.color("horizon")) {
    const float scale = props.real("scale");
    if (!(scale >= 0)) {
      throw props.error("scale", "must not be negative, got " + std::to_string(scale));
    }
    zenith_ *= scale;
    horizon_ *= scale;
  }

  bool is_environment() const override { return true; }
  Rgb eval_environment(const Vec3& d) const override {
    return horizon_ + (zenith_ - horizon_) * std::max(d.y, 0.f);
  }

  // A gradient this smooth needs no importance sampling: uniform over the sphere.
  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& u) const override {
    const float y = 1 - 2 * u.y;
    const float r = std::sqrt(std::max(0.f, 1 - y * y));
    DirectSample sample;
    sample.d = Vec3(r * std::cos(2 * kPi * u.x), y, r * std::sin(2 * kPi * u.x));
    sample.pdf = pdf_environment(sample.d);
    sample.radiance = eval_environment(sample.d);
    return sample;
  }
  float pdf_environment(const Vec3& /*d*/) const override { return 1 / (4 * kPi); }

  // The resolution of the light: `clustered` divides an environment into cells with it, for direct
  // light. For light after a bounce it also needs sample_emission and emission_density. The kink at
  // the horizon is between two rows.
  std::optional<EnvironmentGrid> cell_grid() const override {
    EnvironmentGrid grid;
    grid.columns = 64;
    grid.rows = 32;
    grid.smooth_quads = true;
    return grid;
  }

  // The importances of the thesis need light points.
  std::optional<LightPoints> light_points(const Scene& /*scene*/, RenderContext& /*context*/,
                                          uint32_t count) const override {
    const SpherePartition cells(count);
    LightPoints points;
    points.extent.assign(count, cells.cell_solid_angle());
    for (uint32_t i = 0; i < count; ++i) {
      points.position.push_back(cells.centre(i));
      points.power.push_back(eval_environment(cells.centre(i)) * cells.cell_solid_angle());
    }
    return points;
  }

 private:
  Rgb zenith_;
  Rgb horizon_;
};

}  // namespace

KINOME_PLUGIN(SkyGradient, Category::kEmitter, "sky_gradient",
              "A sky that fades from the zenith (+y) to the horizon.", kParameters);
