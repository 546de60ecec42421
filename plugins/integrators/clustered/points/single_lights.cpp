#include "clustered/points/single_lights.h"

#include <numeric>

#include "kinome/wide/surface_point.h"
#include "transport/rays.h"

namespace kinome {

using namespace wide;
using transport::Vertices;

SingleLights::SingleLights(const transport::SceneTable& scene, const Sampler& sampler, size_t rays)
    : scene_(scene.scene()),
      sampler_(sampler),
      numbers_(rays),
      arena_(transport::Surfaces::most_points(scene, rays)),
      all_(arena_.indices()),
      u_(arena_.two()),
      light_{arena_.three(), arena_.floats(), arena_.floats(), arena_.three(), arena_.floats()},
      wo_(arena_.three()),
      answer_(transport::make_answer(arena_)),
      reflected_(arena_.three()),
      rays_(arena_.rays()),
      occlusion_(arena_.capacity()) {
  std::iota(all_, all_ + arena_.capacity(), 0u);
}

void SingleLights::sample(const PixelSamples& samples, const Vertices& vertices,
                          const Emitter& emitter, uint32_t dimension, RenderCounters& counters) {
  const transport::Surfaces& surfaces = *vertices.surfaces;
  const SurfaceBlock& points = surfaces.points();
  const size_t count = surfaces.scattering();
  if (!emitter.is_delta()) {
    numbers_.fill_2d(sampler_, samples, dimension, vertices.owner, count, u_);
  }
  emitter.sample_direct_block(points.p, u_, count, light_);
  transport::leave_out_own_rounding(emitter, points, all_, count, light_);
  for_lanes(count, [&](size_t i) {
    wide::frame_at(points, i).to_local(wide::Vec3::load(light_.d, i)).store(wo_, i);
  });
  BsdfQuery query;
  query.wo = wo_;
  query.lobes = Lobe::kDiffuse | Lobe::kGlossy;
  transport::shade(surfaces, query, answer_);
  for_lanes(count, [&](size_t i) {
    const Float pdf = Float::load(light_.pdf + i);
    const Mask is_sample = Float::load(surfaces.live() + i) > 0.f && pdf > 0.f;
    wide::Rgb value = wide::Rgb::load(answer_.f, i) * wide::Rgb::load(light_.radiance, i) / pdf;
    if (vertices.throughput.x) value = value * wide::Rgb::load(vertices.throughput, i);
    const Mask on = is_sample && !is_black(value);
    counters[RayKind::kShadow] += wide::count(on);
    counters.skipped_shadow_rays += wide::count(is_sample && !on);
    value.store(reflected_, i);
    transport::put_shadow_rays(points, i, wide::Vec3::load(light_.d, i),
                               Float::load(light_.distance + i), on, true, rays_);
  });
}

void SingleLights::add(const PixelSamples& samples, const Vertices& vertices,
                       std::span<const Emitter* const> emitters, uint32_t dimension,
                       const Columns3& radiance, RenderCounters& counters) {
  const size_t count = vertices.surfaces->scattering();
  for (const Emitter* const emitter : emitters) {
    {
      const StageTimer timer(counters.stage_seconds["evaluate"]);
      sample(samples, vertices, *emitter, dimension, counters);
    }
    dimension += 2;
    const StageTimer timer(counters.stage_seconds["shadow"]);
    occlusion_.trace(scene_, rays_, count, counters);
    for (size_t i = 0; i < count; ++i) {
      // Neither off nor occluded.
      if (!(rays_[i / kBlockLanes].tmax[i % kBlockLanes] >= 0)) continue;
      const uint32_t k = vertices.owner[i];
      radiance.set(k, radiance.at(k) + reflected_.at(i));
    }
  }
}

}  // namespace kinome
