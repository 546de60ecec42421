// An emitter with a fault, for tests of the program's reaction.

#include <cmath>

#include "faulty.h"
#include "kinome/clustered_light.h"
#include "kinome/emitter.h"
#include "kinome/shape.h"
#include "kinome/warp.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_FAULT_PARAMETER};

/// A uniformly sampled sky that is brighter toward +x, except for its fault; in a shape, an area
/// light.
class FaultyEmitter final : public Emitter, public ClusteredLight {
 public:
  explicit FaultyEmitter(const Properties& props)
      : fault_(props), is_lamp_(props.string("fault").starts_with("lamp")) {}

  bool is_environment() const override { return !is_lamp_; }
  bool is_surface() const override { return is_lamp_; }
  Rgb eval_environment(const Vec3& d) const override {
    fault_.throw_if("eval", "shine");
    fault_.crash_if("in eval");
    if (fault_.is("edges")) return Rgb(std::sin(200 * d.x) > 0 ? 1.f : 0.1f);
    return Rgb(fault_.is("nan") && d.y > 0.5f ? kNan : 1 + 0.5f * d.x);
  }
  Rgb eval_surface(const SurfaceInteraction& si) const override {
    return Rgb(si.wi.z > 0 ? (fault_.is("lamp radiance") ? 1.02f : 1.f) : 0.f);
  }

  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const override {
    if (is_lamp_) return sample_lamp(p, u);
    DirectSample sample;
    sample.d = square_to_uniform_sphere(u);
    if (fault_.is("half")) sample.d.y = std::abs(sample.d.y);
    sample.pdf = fault_.is("pdf") ? 1.02f / (4 * kPi) : pdf_environment(sample.d);
    sample.radiance = eval_environment(sample.d) * (fault_.is("radiance") ? 1.02f : 1.f);
    if (fault_.is("length")) sample.d *= 1.01f;
    return sample;
  }
  float pdf_environment(const Vec3& d) const override {
    if (fault_.is("no pdf") && d.y > 0.8f) return 0;
    return (fault_.is("negative pdf") ? -1 : fault_.is("twice") ? 2 : 1) / (4 * kPi);
  }
  float pdf_surface(const Vec3& p, const SurfaceInteraction& si) const override {
    return shape()->pdf_solid_angle(p, si) * (fault_.is("lamp pdf") ? 1.02f : 1.f);
  }

  std::optional<EnvironmentGrid> cell_grid() const override {
    EnvironmentGrid grid{64, 32, 0, glm::mat3(1.f), true, fault_.is("bilinear")};
    if (fault_.is("bilinear")) grid.columns = 4;
    return grid;
  }
  bool eval_grid_batch(std::span<const Vec2> places, std::span<Rgb> radiance) const override {
    for (size_t i = 0; i < places.size(); ++i) radiance[i] = at(places[i]);
    return !fault_.is("bilinear");
  }
  bool eval_grid_corners(int row, int first, std::span<Rgb> radiance) const override {
    for (size_t i = 0; i < radiance.size(); ++i) {
      radiance[i] = at({static_cast<float>(first) + static_cast<float>(i), row});
      if (fault_.is("corners")) radiance[i] *= 1.02f;
    }
    return !fault_.is("bilinear");
  }
  bool eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                              std::span<float> pdf) const override {
    const float factor = fault_.is("batch") ? 1.02f : 1.f;
    for (size_t i = 0; i < d.size(); ++i) radiance[i] = eval_environment(d[i]) * factor;
    for (size_t i = 0; i < pdf.size(); ++i) pdf[i] = pdf_environment(d[i]);
    return true;
  }
  void sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                           const DirectBlock& out) const override {
    Emitter::sample_direct_block(p, u, count, out);
    for (size_t i = 0; i < count; ++i) out.pdf[i] *= fault_.is("block") ? 1.02f : 1.f;
  }

 private:
  /// Returns the radiance at a position of the grid.
  Rgb at(const Vec2& place) const {
    const float shift = fault_.is("grid") ? 0.5f : 0.f;
    const float phi = (place.x + shift) * 2 * kPi / 64, theta = place.y * kPi / 32;
    return eval_environment(
        {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)});
  }
  std::optional<DirectSample> sample_lamp(const Vec3& p, const Vec2& u) const {
    if (fault_.is("lamp delta")) return DirectSample{Vec3(0, 1, 0), 1, 0.5f, Rgb(1.f), true};
    const auto surface = shape()->sample_solid_angle(p, u);
    if (!surface) return std::nullopt;
    const Vec3 to = surface->si.p - p;
    DirectSample sample{glm::normalize(to), glm::length(to), surface->pdf, Rgb(1.f), false};
    if (!(glm::dot(surface->si.n, sample.d) < 0)) return std::nullopt;
    if (fault_.is("lamp aim")) sample.d = -sample.d;
    return sample;
  }

  Fault fault_;
  bool is_lamp_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::FaultyEmitter, kinome::Category::kEmitter, "faulty", "Has a fault.",
              kinome::test::kTable);
