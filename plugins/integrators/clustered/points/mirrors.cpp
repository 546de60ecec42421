#include "clustered/points/mirrors.h"

#include "kinome/wide/surface_point.h"
#include "transport/rays.h"

namespace kinome {

using namespace wide;
using transport::Surfaces;
using transport::Vertices;

Mirrors::Mirrors(const transport::SceneTable& scene, const Sampler& sampler, size_t rays)
    : scene_(scene),
      sampler_(sampler),
      numbers_(rays),
      arena_(Surfaces::most_points(scene, rays)),
      u1_(arena_.floats()),
      u2_(arena_.two()),
      answer_(transport::make_answer(arena_)),
      d_(arena_.three()),
      carried_(arena_.three()),
      light_(arena_.three()),
      rays_(arena_.rays()),
      sort_(arena_.capacity()),
      traced_(arena_.ray_hits()),
      met_{{scene, rays}, {scene, rays}},
      owner_{arena_.indices(), arena_.indices()},
      throughput_{arena_.three(), arena_.three()} {}

void Mirrors::make_rays(const PixelSamples& samples, const Vertices& vertices,
                        uint32_t dimension) {
  const Surfaces& surfaces = *vertices.surfaces;
  const SurfaceBlock& points = surfaces.points();
  const size_t count = surfaces.reflecting();
  numbers_.fill_1d(sampler_, samples, dimension, vertices.owner, count, u1_);
  numbers_.fill_2d(sampler_, samples, dimension + 1, vertices.owner, count, u2_);
  BsdfQuery query;
  query.u1 = u1_;
  query.u2 = u2_;
  query.lobes = Lobe::kDelta;
  transport::shade(surfaces, query, answer_);
  for_lanes(count, [&](size_t i) {
    const wide::Rgb weight = wide::Rgb::load(answer_.weight, i);
    const Mask on = Float::load(surfaces.live() + i) > 0.f &&
                    Float::load(answer_.sample_pdf + i) > 0.f && !is_black(weight);
    const wide::Rgb before =
        vertices.throughput.x ? wide::Rgb::load(vertices.throughput, i) : wide::Rgb(1.f);
    (before * weight).store(carried_, i);
    const wide::Vec3 d = wide::frame_at(points, i).to_world(wide::Vec3::load(answer_.wo, i));
    d.store(d_, i);
    transport::put_shadow_rays(points, i, d, Float(kInfinity), on, false, rays_);
  });
  for (size_t i = 0; vertices.straight && i < count; ++i) {
    const bool turns = surfaces.live()[i] > 0 && answer_.is_delta[i] != kNullSample;
    if (turns) vertices.straight[vertices.owner[i]] = 0;
  }
}

Vertices Mirrors::reflect(const PixelSamples& samples, const Vertices& vertices,
                          uint32_t dimension, const Columns3& radiance,
                          RenderCounters& counters) {
  size_t on = 0;
  {
    const StageTimer timer(counters.stage_seconds["shade"]);
    make_rays(samples, vertices, dimension);
    on = sort_.sort(rays_, vertices.surfaces->reflecting());
    sort_.copy(&traced_[0].ray, sizeof(RayHit16));
    transport::clear_hits(traced_, on);
  }
  const StageTimer timer(counters.stage_seconds["bounce"]);
  counters[RayKind::kBsdf] += on;
  scene_.scene().intersect(traced_, padded(on) / kBlockLanes, Coherence::kIncoherent, counters);
  current_ = 1 - current_;
  Surfaces& met = met_[current_];
  met.find(traced_, on, Surfaces::Which::kAll);
  uint32_t* const owner = owner_[current_];
  const Columns3& throughput = throughput_[current_];
  for_lanes(met.points().count, [&](size_t i) {
    const Int from = as_int(gather(sort_.order(), Int::load(met.points().ray + i)));
    gather(vertices.owner, from).store(owner + i);
    gather(carried_, from).store(throughput, i);
  });
  Vertices next{&met, owner, throughput};
  next.straight = vertices.straight;
  add_light(next, radiance);
  if (scene_.scene().environment()) add_environment(vertices, radiance);
  return next;
}

void Mirrors::add_light(const Vertices& met, const Columns3& radiance) {
  for (const Surfaces::Range& range : met.surfaces->ranges()) {
    if (!range.row->emitter) continue;
    const size_t first = range.first;
    range.row->emitter->eval_surface_block(met.surfaces->points().part(first, range.count), {},
                                           light_.from(first), nullptr);
    for (size_t i = first; i < first + range.count; ++i) {
      const uint32_t k = met.owner[i];
      radiance.set(k, radiance.at(k) + met.throughput.at(i) * light_.at(i));
    }
  }
}

void Mirrors::add_environment(const Vertices& vertices, const Columns3& radiance) {
  const auto missed = met_[current_].missed();
  const uint32_t* const from = sort_.order();
  // Directions in the order of missed rays; d_ is in the order of the points that they start from.
  const Columns3 toward = answer_.wo;
  for (size_t i = 0; i < missed.size(); ++i) toward.set(i, d_.at(from[missed[i]]));
  scene_.scene().environment()->eval_environment_block(toward, missed.size(), light_, nullptr);
  for (size_t i = 0; i < missed.size(); ++i) {
    const uint32_t k = vertices.owner[from[missed[i]]];
    if (vertices.straight && vertices.straight[k] > 0) continue;
    radiance.set(k, radiance.at(k) + carried_.at(from[missed[i]]) * light_.at(i));
  }
}

}  // namespace kinome
