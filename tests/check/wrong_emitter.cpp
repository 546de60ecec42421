// A uniform sky, except for its fault.

#include <cmath>
#include <stdexcept>

#include "kinome/clustered_light.h"
#include "kinome/emitter.h"
#include "kinome/sphere_partition.h"
#include "kinome/warp.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {
    KINOME_WRONG_PARAMETER,
    {"scale", ParameterType::kFloat, "1", "Factor of the radiance; not negative."},
};

class WrongSky final : public Emitter, public ClusteredLight {
 public:
  explicit WrongSky(const Properties& props) : wrong_(props), scale_(props.real("scale")) {
    if (wrong_.is("scale of 0")) scale_ = scale_ / scale_;
    if (wrong_.is("exception") && scale_ < 0) throw std::out_of_range("scale");
    if (wrong_.is("no message") && scale_ < 0) throw Error("");
    if (scale_ < 0 && !wrong_.is("exception")) throw props.error("scale", "must not be negative");
  }

  bool is_environment() const override { return true; }
  Rgb eval_environment(const Vec3& d) const override {
    if (wrong_.is("negative")) return Rgb(d.x > 0.9f ? -scale_ : scale_ / 100);
    // A step that the grid doesn't include.
    if (wrong_.is("grid")) return Rgb(d.y > 0.3f ? 2 * scale_ : scale_);
    return Rgb(scale_);
  }
  float pdf_environment(const Vec3& /*d*/) const override {
    return kUniformSpherePdf * wrong_.or_wrong("half density", 1.f, 0.5f);
  }
  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& u) const override {
    DirectSample sample;
    sample.d = square_to_uniform_sphere(u);
    if (wrong_.is("one side")) sample.d.y = std::abs(sample.d.y);
    sample.pdf = pdf_environment(sample.d) * wrong_.or_wrong("twice the density", 1.f, 2.f);
    sample.radiance = eval_environment(sample.d) * wrong_.or_wrong("other radiance", 1.f, 1.05f);
    sample.d *= wrong_.or_wrong("length", 1.f, 1.01f);
    sample.distance = wrong_.or_wrong("distance", kInfinity, 1.f);
    return sample;
  }
  bool eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                              std::span<float> pdf) const override {
    const float factor = wrong_.or_wrong("batch", 1.f, 1.05f);
    for (size_t i = 0; i < d.size(); ++i) radiance[i] = eval_environment(d[i]) * factor;
    for (size_t i = 0; i < pdf.size(); ++i) pdf[i] = pdf_environment(d[i]);
    return true;
  }
  void prepare(const Aabb& bounds) override {
    centre_ = bounds.centre();
    radius_ = 0.51f * glm::length(bounds.extent());
  }
  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const override {
    EmissionSample ray;
    const Vec3 toward = square_to_uniform_sphere(direction);
    // The result of `const Frame frame(toward)` when Frame was an aggregate: only s is set.
    const Frame frame = wrong_.is("frame") ? Frame(toward, Vec3(0, 1, 0), Vec3(0, 0, 1))
                                           : Frame::from_normal(toward);
    const float radius = radius_ * wrong_.or_wrong("disk", 1.f, 0.7f);
    const Vec2 place = radius * square_to_disk_concentric(position);
    const float before = wrong_.or_wrong("start", 1.f, 0.1f);
    ray.o = centre_ + before * radius_ * toward + frame.s * place.x + frame.t * place.y;
    ray.d = -toward;
    ray.pdf_direction = kUniformSpherePdf * wrong_.or_wrong("sample's density", 1.f, 2.f);
    ray.pdf_position = pdf_position() / sqr(radius / radius_);
    ray.power = eval_environment(toward) / (kUniformSpherePdf * ray.pdf_position);
    if (wrong_.is("emission")) ray.power *= 1.1f;
    if (wrong_.is("emission direction")) ray.d = Vec3(ray.d.x, ray.d.y, std::abs(ray.d.z));
    return ray;
  }
  void sample_emission_block(const Columns2& position, const Columns2& direction, size_t count,
                             const EmissionBlock& out) const override {
    Emitter::sample_emission_block(position, direction, count, out);
    for (size_t i = 0; i < count && wrong_.is("emission block"); ++i) {
      out.power.set(i, out.power.at(i) * 1.1f);
    }
  }
  std::optional<EmissionDensity> emission_density(const Vec3& /*d*/) const override {
    return EmissionDensity{kUniformSpherePdf * wrong_.or_wrong("emission density", 1.f, 2.f),
                           pdf_position() / sqr(wrong_.or_wrong("disk", 1.f, 0.7f))};
  }
  std::optional<EnvironmentGrid> cell_grid() const override {
    EnvironmentGrid grid;
    grid.columns = 16;
    grid.rows = 8;
    grid.bilinear_quads = true;
    return grid;
  }
  std::optional<LightPoints> light_points(const Scene& /*scene*/, RenderContext& /*context*/,
                                          uint32_t count) const override {
    const SpherePartition cells(count);
    LightPoints points;
    points.extent.assign(count, wrong_.or_wrong("extent", cells.cell_solid_angle(), 0.f));
    for (uint32_t i = 0; i < count; ++i) {
      points.position.push_back(cells.centre(i));
      points.power.push_back(
          Rgb(scale_ * cells.cell_solid_angle() * wrong_.or_wrong("points", 1.f, 0.5f)));
    }
    return points;
  }

 private:
  /// Density per area across the light.
  float pdf_position() const {
    return wrong_.or_wrong("twice the density of positions", 1.f, 2.f) / (kPi * sqr(radius_));
  }

  Wrong wrong_;
  float scale_;
  Vec3 centre_{0.f};
  float radius_ = 1;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongSky, kinome::Category::kEmitter, "wrong", "Has a fault.",
              kinome::test::kTable);
