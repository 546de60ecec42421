#include "kinome/sky.h"

#include <algorithm>
#include <cmath>

#include "kinome/distant_disk.h"
#include "kinome/flux_grid.h"
#include "kinome/warp.h"

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

/// Direction of a point of the unit square: azimuth and polar angle around z.
Vec3 direction_at(const Vec2& uv) {
  const float phi = 2 * kPi * uv.x, theta = kPi * uv.y;
  const float sine = std::sin(theta);
  return {sine * std::cos(phi), sine * std::sin(phi), std::cos(theta)};
}

Vec2 position_of(const Vec3& d) {
  const float turn = std::atan2(d.y, d.x) * (0.5f * kInvPi);
  return {turn < 0 ? turn + 1 : turn, std::atan2(std::hypot(d.x, d.y), d.z) * kInvPi};
}

/// Radiance times the solid angle that a unit of the square's area has at uv, up to a factor.
float probed_flux(const Sky& sky, const Vec2& uv) {
  const Vec3 d = direction_at(uv);
  const float flux = luminance(glm::abs(sky.radiance(d))) * std::hypot(d.x, d.y);
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
  const FluxGrid& flux = tables_->flux_of(*this);
  if (flux.is_black()) return kUniformSpherePdf;
  const float sine = std::max(std::hypot(d.x, d.y), kMinSine);
  return flux.pdf(position_of(d)) / (2 * kPi * kPi * sine);
}

std::optional<DirectSample> Sky::sample_direct(const Vec3& /*p*/, const Vec2& u) const {
  const auto sample = tables_->flux_of(*this).sample(u);
  DirectSample direct;
  direct.d = sample ? direction_at(sample->uv) : square_to_uniform_sphere(u);
  direct.pdf = pdf_environment(direct.d);
  direct.radiance = radiance(direct.d);
  return direct;
}

std::optional<EmissionSample> Sky::sample_emission(const Vec2& position,
                                                   const Vec2& direction) const {
  return emission_of(*this, tables_->disk, position, direction);
}

std::optional<EmissionDensity> Sky::emission_density(const Vec3& d) const {
  return EmissionDensity{pdf_environment(-d), tables_->disk.pdf()};
}

}  // namespace kinome
