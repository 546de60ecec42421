#include "kinome/clustered_light.h"

#include "kinome/sphere_partition.h"

namespace kinome {
namespace {

/// Directions by which a light point is estimated: a square of this side in its cell.
constexpr int kProbesOfSide = 4;

LightPoints probed_points(const Emitter& environment, uint32_t count) {
  const SpherePartition cells(count);
  const float extent = cells.cell_solid_angle();
  LightPoints points;
  points.kind = LightPoints::Kind::kDistant;
  points.extent.assign(count, extent);
  for (uint32_t i = 0; i < count; ++i) {
    Rgb sum(0.f);
    for (int k = 0; k < kProbesOfSide * kProbesOfSide; ++k) {
      const auto x = static_cast<float>(k % kProbesOfSide);
      const auto y = static_cast<float>(k / kProbesOfSide);
      const Vec2 u = Vec2(x + 0.5f, y + 0.5f) / static_cast<float>(kProbesOfSide);
      sum += environment.eval_environment(cells.sample(i, u));
    }
    points.position.push_back(cells.centre(i));
    points.power.push_back(sum * (extent / (kProbesOfSide * kProbesOfSide)));
  }
  return points;
}

}  // namespace

ClusteredLight::~ClusteredLight() = default;

const ClusteredLight* clustered_light(const Emitter& emitter) {
  return dynamic_cast<const ClusteredLight*>(&emitter);
}

std::optional<LightPoints> light_points_of(const Emitter& emitter, const Scene& scene,
                                           RenderContext& context, uint32_t count) {
  if (const ClusteredLight* const own = clustered_light(emitter)) {
    if (auto points = own->light_points(scene, context, count)) return points;
  }
  if (!emitter.is_environment() || count == 0) return std::nullopt;
  return probed_points(emitter, count);
}

std::optional<EnvironmentGrid> cell_grid_of(const Emitter& emitter) {
  if (const ClusteredLight* const own = clustered_light(emitter)) {
    if (const auto grid = own->cell_grid()) return grid;
  }
  if (!emitter.is_environment()) return std::nullopt;
  return EnvironmentGrid{};
}

void eval_environment(const Emitter& emitter, std::span<const Vec3> d, std::span<Rgb> radiance,
                      std::span<float> pdf) {
  const ClusteredLight* const own = clustered_light(emitter);
  if (own && own->eval_environment_batch(d, radiance, pdf)) return;
  for (size_t i = 0; i < d.size(); ++i) radiance[i] = emitter.eval_environment(d[i]);
  for (size_t i = 0; i < pdf.size(); ++i) pdf[i] = emitter.pdf_environment(d[i]);
}

}  // namespace kinome
