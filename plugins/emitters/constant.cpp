/// An environment with the same radiance in every direction.
///
///     <emitter type="constant"><rgb name="radiance" value="1 .9 .8"/></emitter>

#include <algorithm>

#include "emission.h"
#include "environment.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "kinome/sphere_partition.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"radiance", ParameterType::kEmission, "1", "Radiance from every direction."},
    ignored_row("to_world", ParameterType::kTransform, "all directions have the same radiance"),
};

class ConstantEnvironment final : public Environment {
 public:
  explicit ConstantEnvironment(const Properties& props)
      : radiance_(read_emission(props, "radiance")),
        pdf_(is_black(radiance_) ? 0 : kUniformSpherePdf) {}

  Rgb eval_environment(const Vec3& /*d*/) const override { return radiance_; }
  float pdf_environment(const Vec3& /*d*/) const override { return pdf_; }

  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& u) const override {
    if (pdf_ == 0) return std::nullopt;
    DirectSample sample;
    sample.d = square_to_uniform_sphere(u);
    sample.pdf = pdf_;
    sample.radiance = radiance_;
    return sample;
  }

  void sample_direct_block(const Columns3& /*p*/, const Columns2& u, size_t count,
                           const DirectBlock& out) const override {
    wide::for_lanes(count, [&](size_t i) {
      warp::square_to_uniform_sphere<wide::Vec3>(wide::Vec2::load(u, i)).store(out.d, i);
      wide::Rgb(radiance_).store(out.radiance, i);
      wide::Float(kInfinity).store(out.distance + i);
      wide::Float(pdf_).store(out.pdf + i);
      wide::Float(0.f).store(out.is_delta + i);
    });
  }
  void eval_environment_block(const Columns3& /*d*/, size_t count, const Columns3& radiance,
                              float* pdf) const override {
    wide::for_lanes(count, [&](size_t i) {
      wide::Rgb(radiance_).store(radiance, i);
      if (pdf) wide::Float(pdf_).store(pdf + i);
    });
  }

  std::optional<EnvironmentGrid> cell_grid() const override {
    return EnvironmentGrid{64, 32, 0, glm::mat3(1.f), true};
  }

  bool eval_grid_batch(std::span<const Vec2> /*places*/, std::span<Rgb> radiance) const override {
    std::fill(radiance.begin(), radiance.end(), radiance_);
    return true;
  }

  /// Centres of cells of equal solid angle, independent of the seed.
  std::optional<LightPoints> light_points(const Scene& /*scene*/, RenderContext& /*context*/,
                                          uint32_t count) const override {
    const SpherePartition cells(count);
    return distant_points(cells, std::vector<Rgb>(count, radiance_ * cells.cell_solid_angle()),
                          [&](uint32_t i) { return cells.centre(i); });
  }

 private:
  Rgb radiance_;
  float pdf_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::ConstantEnvironment, kinome::Category::kEmitter, "constant",
              "An environment with the same radiance in every direction.", kinome::kTable);
