#include "kinome/sky.h"

#include <cmath>

#include "kinome/distant_disk.h"
#include "kinome/flux_grid.h"
#include "kinome/warp.h"

namespace kinome {
namespace {

constexpr glm::uvec2 kCells{256, 128};
constexpr uint32_t kProbesOfSide = 2;  ///< of each cell
constexpr float kUniform = 0.25f * kInvPi;

/// Direction of a point of the unit square, with equal areas for equal solid angles.
Vec3 direction_at(const Vec2& uv) {
  return warp::spherical_direction<Vec3, float>(1 - 2 * uv.y, uv.x * (2 * kPi));
}

Vec2 position_of(const Vec3& d) {
  const float turn = std::atan2(d.y, d.x) * (0.5f * kInvPi);
  return {turn < 0 ? turn + 1 : turn, 0.5f * (1 - d.z)};
}

}  // namespace

/// The distribution is made when it is first needed, because constructors can't call radiance().
struct Sky::Tables {
  DistantDisk disk;
  LazyFluxGrid flux;

  const FluxGrid& flux_of(const Sky& sky) {
    return flux.get([&] {
      return FluxGrid(kCells, kProbesOfSide, [&](const Vec2& uv) {
        return luminance(glm::abs(sky.radiance(direction_at(uv))));
      });
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
  return flux.is_black() ? kUniform : kUniform * flux.pdf(position_of(d));
}

std::optional<DirectSample> Sky::sample_direct(const Vec3& /*p*/, const Vec2& u) const {
  const auto sample = tables_->flux_of(*this).sample(u);
  DirectSample direct;
  direct.d = direction_at(sample ? sample->uv : u);
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
