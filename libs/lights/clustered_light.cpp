#include "kinome/clustered_light.h"

#include <algorithm>
#include <string>

#include "kinome/error.h"
#include "kinome/render_context.h"
#include "kinome/sampler.h"
#include "kinome/sphere_partition.h"

namespace kinome {
namespace {

/// Directions by which a light point is estimated: a square of this side in its cell.
constexpr uint32_t kProbesOfPoint = 4;
/// Grid of an environment that has none: quads of half a degree, whose Gauss points a disk as large
/// as the sun never misses.
constexpr int kColumns = 720, kRows = 360;
constexpr int kMaxQuadsOfSide = 1 << 15;

/// Each probe is at a random position in its part of the cell, so that the mean over seeds is
/// exact.
LightPoints probed_points(const Emitter& environment, uint32_t count, uint64_t seed) {
  const SpherePartition cells(count);
  const float extent = cells.cell_solid_angle();
  LightPoints points;
  points.kind = LightPoints::Kind::kDistant;
  points.extent.assign(count, extent);
  for (uint32_t i = 0; i < count; ++i) {
    Rgb sum(0.f);
    for (uint32_t k = 0; k < kProbesOfPoint * kProbesOfPoint; ++k) {
      const uint64_t bits = hash_words(seed, i, k);
      const Vec2 inside(static_cast<float>(bits >> 40) * 0x1p-24f,
                        static_cast<float>((bits >> 8) & 0xffffff) * 0x1p-24f);
      const Vec2 part(static_cast<float>(k % kProbesOfPoint),
                      static_cast<float>(k / kProbesOfPoint));
      const Vec2 u = (part + inside) / static_cast<float>(kProbesOfPoint);
      sum += environment.eval_environment(cells.sample(i, u));
    }
    points.position.push_back(cells.centre(i));
    points.power.push_back(sum * (extent / (kProbesOfPoint * kProbesOfPoint)));
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
  return probed_points(emitter, count, context.job.seed());
}

std::optional<EnvironmentGrid> cell_grid_of(const Emitter& emitter) {
  if (const ClusteredLight* const own = clustered_light(emitter)) {
    if (const auto grid = own->cell_grid()) {
      if (std::min(grid->columns, grid->rows) < 1 ||
          std::max(grid->columns, grid->rows) > kMaxQuadsOfSide) {
        throw Error("cell_grid() of an environment must have between 1 and " +
                    std::to_string(kMaxQuadsOfSide) + " columns and rows, got " +
                    std::to_string(grid->columns) + " and " + std::to_string(grid->rows));
      }
      return grid;
    }
  }
  if (!emitter.is_environment()) return std::nullopt;
  EnvironmentGrid grid;
  grid.columns = kColumns;
  grid.rows = kRows;
  grid.is_probed = true;
  return grid;
}

void eval_environment(const Emitter& emitter, std::span<const Vec3> d, std::span<Rgb> radiance,
                      std::span<float> pdf) {
  const ClusteredLight* const own = clustered_light(emitter);
  if (own && own->eval_environment_batch(d, radiance, pdf)) return;
  for (size_t i = 0; i < d.size(); ++i) radiance[i] = emitter.eval_environment(d[i]);
  for (size_t i = 0; i < pdf.size(); ++i) pdf[i] = emitter.pdf_environment(d[i]);
}

}  // namespace kinome
