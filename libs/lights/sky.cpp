#include "kinome/sky.h"

#include <algorithm>
#include <cmath>

#include "kinome/distant_disk.h"
#include "kinome/flux_grid.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

/// Cells of equal angles, and probes along each side of a cell. Probes are 0.35 degrees apart, so
/// that a disk as large as the sun is never missed.
constexpr glm::uvec2 kSkyCells{512, 256};
constexpr uint32_t kProbesOfCell = 2;
/// Maximum flux of a probe, so that sums stay finite.
constexpr float kMaxProbe = 1e30f;
/// Minimum sine of the polar angle in densities.
constexpr float kMinSine = 1e-6f;

/// Direction of a point of the unit square: azimuth and polar angle around z. F is float or
/// wide::Float.
template <class F>
wide::formulas::VecOf<F> direction_at(const wide::formulas::Vec2Of<F>& uv) {
  using namespace wide::formulas;
  const F phi = uv.x * (2 * kPi), theta = uv.y * kPi;
  const F sine = sin(theta);
  return {sine * cos(phi), sine * sin(phi), cos(theta)};
}

template <class F>
F sine_of(const wide::formulas::VecOf<F>& d) {
  using namespace wide::formulas;
  return sqrt(d.x * d.x + d.y * d.y);
}

template <class F>
wide::formulas::Vec2Of<F> position_of(const wide::formulas::VecOf<F>& d) {
  using namespace wide::formulas;
  const F turn = atan2(d.y, d.x) * (0.5f * kInvPi);
  return {select(turn < 0.f, turn + 1.f, turn), atan2(sine_of<F>(d), d.z) * kInvPi};
}

/// Density per solid angle of the direction d.
template <class F>
F density(const FluxGrid& flux, const wide::formulas::VecOf<F>& d) {
  using namespace wide::formulas;
  if (flux.is_black()) return F(kUniformSpherePdf);
  return flux.pdf(position_of<F>(d)) / (max(sine_of<F>(d), F(kMinSine)) * (2 * kPi * kPi));
}

/// Radiance times the solid angle that a unit of the square's area has at uv, up to a factor.
float probed_flux(const Sky& sky, const Vec2& uv) {
  const Vec3 d = direction_at<float>(uv);
  const float flux = luminance(glm::abs(sky.radiance(d))) * sine_of<float>(d);
  return std::isfinite(flux) ? std::min(flux, kMaxProbe) : 0.f;
}

}  // namespace

/// The distribution is made when it is first needed, because constructors can't call radiance().
struct Sky::Tables {
  DistantDisk disk;
  LazyFluxGrid flux;

  const FluxGrid& flux_of(const Sky& sky) {
    return flux.get([&] {
      return FluxGrid(kSkyCells, kProbesOfCell,
                      [&](const Vec2& uv) { return probed_flux(sky, uv); });
    });
  }
};

Sky::Sky() : tables_(std::make_unique<Tables>()) {}
Sky::~Sky() = default;

void Sky::prepare(const Aabb& scene_bounds) {
  tables_->disk.prepare(scene_bounds);
}

float Sky::pdf_environment(const Vec3& d) const {
  return density<float>(tables_->flux_of(*this), d);
}

std::optional<DirectSample> Sky::sample_direct(const Vec3& /*p*/, const Vec2& u) const {
  const FluxGrid& flux = tables_->flux_of(*this);
  const auto sample = flux.sample(u);
  DirectSample direct;
  direct.d = sample ? direction_at<float>(sample->uv) : square_to_uniform_sphere(u);
  direct.pdf = density<float>(flux, direct.d);
  direct.radiance = radiance(direct.d);
  return direct;
}

void Sky::sample_direct_block(const Columns3& /*p*/, const Columns2& u, size_t count,
                              const DirectBlock& out) const {
  const FluxGrid& flux = tables_->flux_of(*this);
  wide::for_lanes(count, [&](size_t i) {
    const wide::Vec2 u_wide = wide::Vec2::load(u, i);
    const wide::Vec3 d = flux.is_black() ? warp::square_to_uniform_sphere<wide::Vec3>(u_wide)
                                         : direction_at<wide::Float>(flux.sample(u_wide).uv);
    d.store(out.d, i);
    wide::Float(kInfinity).store(out.distance + i);
    density<wide::Float>(flux, d).store(out.pdf + i);
    wide::Float(0.f).store(out.is_delta + i);
  });
  for (size_t i = 0; i < count; ++i) out.radiance.set(i, radiance(out.d.at(i)));
}

void Sky::eval_environment_block(const Columns3& d, size_t count, const Columns3& radiances,
                                 float* pdf) const {
  for (size_t i = 0; i < count; ++i) radiances.set(i, radiance(d.at(i)));
  if (!pdf) return;
  const FluxGrid& flux = tables_->flux_of(*this);
  wide::for_lanes(count, [&](size_t i) {
    density<wide::Float>(flux, wide::Vec3::load(d, i)).store(pdf + i);
  });
}

std::optional<EmissionSample> Sky::sample_emission(const Vec2& position,
                                                   const Vec2& direction) const {
  return emission_of(*this, tables_->disk, position, direction);
}

std::optional<EmissionDensity> Sky::emission_density(const Vec3& d) const {
  return EmissionDensity{pdf_environment(-d), tables_->disk.pdf()};
}

}  // namespace kinome
