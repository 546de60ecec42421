#include "transport/direct/direct_light.h"

#include "kinome/wide/surface_point.h"
#include "transport/direct/weights.h"
#include "transport/path_parameters.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

DirectLight::Traced::Traced(const SceneTable& scene, size_t max_points, size_t max_rays)
    : sort(max_points),
      per_ray(max_rays),
      rays(per_ray.ray_hits()),
      met{{scene, max_rays}, {scene, max_rays}} {}

DirectLight::Passing::Passing(const SceneTable& scene, size_t max_points, size_t max_rays)
    : shadows(scene, max_points, max_rays),
      per_point(max_points),
      next{per_point.three(), per_point.floats(), per_point.floats()},
      max_passes(per_point.floats()),
      through{per_point.three(), per_point.floats()} {}

DirectLight::DirectLight(const SceneTable& scene, const Sampler& sampler, const LightSamples& count,
                         size_t rays)
    : scene_(scene),
      sampler_(sampler),
      count_(count),
      max_rays_(rays),
      max_points_(Surfaces::max_points(scene, rays)),
      numbers_(rays),
      arena_(max_points_),
      emitters_(scene, max_points_),
      occlusion_(max_points_, rays),
      wo_(arena_.three()),
      u1_(arena_.floats()),
      u2_(arena_.two()),
      answer_(make_answer(arena_)),
      carried_(arena_.three()),
      light_(arena_.three()),
      destination_(arena_.indices()),
      rays_(arena_.untraced_rays()),
      d_(arena_.three()),
      per_met_(max_points_),
      from_p_(per_met_.three()),
      hit_radiance_(per_met_.three()),
      hit_pdf_(per_met_.floats()) {}

void DirectLight::sample(const PixelSamples& samples, const Vertices& vertices,
                         std::optional<uint32_t> emitter_dimension,
                         std::optional<uint32_t> bsdf_dimension) {
  const SurfaceBlock& points = vertices.surfaces->points();
  const size_t count = vertices.surfaces->reflecting();
  const size_t scattering = vertices.surfaces->scattering();
  BsdfQuery query;
  query.lobes = count_.lobes;
  if (emitter_dimension && scattering > 0) {
    emitters_.sample(sampler_, samples, *emitter_dimension, points, vertices.owner, scattering,
                     numbers_);
    for_lanes(scattering, [&](size_t i) {
      frame_at(points, i).to_local(wide::Vec3::load(emitters_.light().d, i)).store(wo_, i);
    });
    query.wo = wo_;
  }
  if (bsdf_dimension) {
    numbers_.fill_1d(sampler_, samples, *bsdf_dimension, vertices.owner, count, u1_);
    numbers_.fill_2d(sampler_, samples, *bsdf_dimension + 1, vertices.owner, count, u2_);
    query.u1 = u1_;
    query.u2 = u2_;
  }
  shade(*vertices.surfaces, query, answer_);
  if (!bsdf_dimension) return;
  const float share = 1 / static_cast<float>(count_.bsdf);
  for_lanes(count, [&](size_t i) {
    // NaN is kept, so that the film can count it.
    const Mask valid =
        is_live(*vertices.surfaces, i) & !(Float::load(answer_.sample_pdf + i) <= 0.f);
    const wide::Rgb carried =
        throughput(vertices, i) * wide::Rgb::load(answer_.weight, i) * Float(share);
    select(valid, carried).store(carried_, i);
  });
  for (size_t i = 0; vertices.drops_straight && i < count; ++i) {
    if (answer_.is_delta[i] == kNullSample) carried_.set(i, kinome::Rgb(0.f));
  }
  if (vertices.straight) update_straight(vertices);
  if (vertices.origins.pdf) find_next_origins(vertices);
}

void DirectLight::find_next_origins(const Vertices& vertices) {
  if (!passing_) passing_ = std::make_unique<Passing>(scene_, max_points_, max_rays_);
  const Surfaces& surfaces = *vertices.surfaces;
  for (const Surfaces::Range& range : surfaces.ranges()) {
    if (!range.row->bsdf->has_null_lobe()) continue;
    range.row->bsdf->null_transmission_block(surfaces.points().part(range.first, range.count),
                                             passing_->through.from(range.first));
  }
  const Origins& from = vertices.origins;
  const Origins& to = passing_->next;
  for_lanes(surfaces.reflecting(), [&](size_t i) {
    const Float is_delta = Float::load(answer_.is_delta + i);
    const Mask is_straight = is_delta == kNullSample;
    const Float passes = select(is_straight, Float::load(from.passes + i) + 1.f);
    const Float straight_pdf =
        Float::load(from.pdf + i) * Float::load(passing_->through.probability + i);
    const Float turned_pdf =
        select(is_delta > 0.f, Float(kInfinity), Float::load(answer_.sample_pdf + i));
    const Float pdf = select(is_straight, straight_pdf, turned_pdf);
    select(passes > static_cast<float>(kMaxPasses), max(pdf, Float(kPdfBeyondPasses)), pdf)
        .store(to.pdf + i);
    passes.store(to.passes + i);
    select(is_straight, wide::Vec3::load(from.p, i), wide::Vec3::load(surfaces.points().p, i))
        .store(to.p, i);
  });
}

/// Clears Vertices::straight for paths whose sample does not go straight through the surface.
void DirectLight::update_straight(const Vertices& vertices) const {
  const float* const live = vertices.surfaces->live();
  for (size_t i = 0; i < vertices.surfaces->reflecting(); ++i) {
    if (live[i] > 0 && answer_.is_delta[i] != kNullSample) vertices.straight[vertices.owner[i]] = 0;
  }
}

void DirectLight::play_roulette(const PixelSamples& samples, const Vertices& vertices,
                                uint32_t dimension) {
  const size_t count = vertices.surfaces->reflecting();
  numbers_.fill_1d(sampler_, samples, dimension, vertices.owner, count, u1_);
  for_lanes(count, [&](size_t i) {
    const wide::Rgb carried = wide::Rgb::load(carried_, i);
    const Float survival = survival_probability(carried);
    const Mask goes_on = Float::load(u1_ + i) < survival;
    select(goes_on, carried / survival).store(carried_, i);
  });
}

Float DirectLight::emitter_pdf(size_t i) const {
  return Float::load(emitters_.light().pdf + i) *
         (emitters_.pick_pdf() * static_cast<float>(count_.emitter));
}

/// Returns the weight of emitter samples i … with density pdf. `passed` is the probability that a
/// BSDF sample goes straight through the surfaces between.
Float DirectLight::emitter_weight(size_t i, const Float& pdf, const Float& passed) const {
  if (count_.bsdf == 0) return 1.f;
  const Mask is_delta = Float::load(emitters_.light().is_delta + i) > 0.f;
  const Float bsdf_pdf = Float::load(answer_.pdf + i) * static_cast<float>(count_.bsdf) * passed;
  return select(is_delta, Float(1.f), power_heuristic(pdf, bsdf_pdf));
}

template <class Fn>
size_t DirectLight::make_emitter_rays(const Vertices& vertices, RenderCounters& counters,
                                      const Fn& weight_of) {
  const StageTimer timer(counters.stage_seconds["shade"]);
  const Surfaces& surfaces = *vertices.surfaces;
  const DirectBlock& sampled = emitters_.light();
  size_t rays = 0;
  for_lanes(surfaces.scattering(), [&](size_t i) {
    const Float pdf = emitter_pdf(i);
    const wide::Rgb light = throughput(vertices, i) * wide::Rgb::load(answer_.f, i) *
                            wide::Rgb::load(sampled.radiance, i) * (weight_of(i, pdf) / pdf);
    const Mask on = is_live(surfaces, i) & !(pdf <= 0.f) & !is_black(light);
    rays += wide::count(on);
    select(on, light).store(light_, i);
    write_shadow_rays(surfaces.points(), i, wide::Vec3::load(sampled.d, i),
                      Float::load(sampled.distance + i), on, true, rays_);
  });
  counters[RayKind::kShadow] += rays;
  counters.skipped_shadow_rays += surfaces.live_reflecting() - rays;
  return rays;
}

/// Returns the index into columns of radiance that the light of each emitter sample belongs to.
const uint32_t* DirectLight::emitter_destinations(const Vertices& vertices) {
  if (scene_.light_groups() == 0) return vertices.owner;
  for_lanes(vertices.surfaces->scattering(), [&](size_t i) {
    const Int emitter = Int::load(emitters_.picked() + i);
    const Int offset = as_int(gather(scene_.group_offsets(), emitter));
    (Int::load(vertices.owner + i) + offset).store(destination_ + i);
  });
  return destination_;
}

void DirectLight::add_emitter_samples(const Vertices& vertices, const Columns3& radiance,
                                      RenderCounters& counters) {
  const Surfaces& surfaces = *vertices.surfaces;
  make_emitter_rays(vertices, counters,
                    [&](size_t i, const Float& pdf) { return emitter_weight(i, pdf, 1.f); });
  // A single delta emitter lights neighbouring pixels from similar directions: rays stay unsorted.
  const bool are_neighbours = !vertices.throughput.x && emitters_.have_common_origin();
  add_arriving(emitter_destinations(vertices), surfaces.scattering(), are_neighbours, radiance,
               counters);
}

void DirectLight::add_passing_emitter_samples(const Vertices& vertices,
                                              const RadianceByPasses& light,
                                              RenderCounters& counters) {
  const size_t count = vertices.surfaces->scattering();
  // Weights depend on the surfaces between, which are known only after tracing.
  if (make_emitter_rays(vertices, counters, [](size_t, const Float&) { return Float(1.f); }) == 0) {
    return;
  }
  const StageTimer timer(counters.stage_seconds["shadow"]);
  StraightShadows& shadows = passing_->shadows;
  float* const max_passes = passing_->max_passes;
  for_lanes(count, [&](size_t i) {
    const Mask is_delta = Float::load(emitters_.light().is_delta + i) > 0.f;
    select(is_delta, Float(0.f), Float(static_cast<float>(light.max_passes))).store(max_passes + i);
  });
  shadows.trace(rays_, count, max_passes, counters);
  const uint32_t* const destination = emitter_destinations(vertices);
  for_lanes(count, [&](size_t i) {
    const wide::Rgb transmittance = wide::Rgb::load(shadows.transmittance(), i);
    const Mask arrives = !is_black(transmittance);
    if (none(arrives)) return;
    const Float passes = Float::load(shadows.passes() + i);
    const Float weight = emitter_weight(i, emitter_pdf(i), Float::load(shadows.probability() + i));
    const wide::Rgb arriving = wide::Rgb::load(light_, i) * transmittance * weight;
    const Mask is_direct = passes <= light.max_direct_passes;
    add_to_owners(arriving, arrives & is_direct, destination + i, light.radiance);
    add_to_owners(arriving, arrives & !is_direct, destination + i, light.beyond);
  });
}

/// Traces the first `count` rays of rays_, and adds light_ of the unoccluded ones to `radiance`.
/// Light i belongs to index destination[i].
void DirectLight::add_arriving(const uint32_t* destination, size_t count, bool are_neighbours,
                               const Columns3& radiance, RenderCounters& counters) {
  const StageTimer timer(counters.stage_seconds["shadow"]);
  if (are_neighbours) {
    Occlusion::trace_in_place(scene_.scene(), rays_, count, counters);
  } else {
    occlusion_.trace(scene_.scene(), rays_, count, counters);
  }
  for_lanes(count, [&](size_t i) {
    const Mask arrives = !(Float::load(rays_[i / kBlockLanes].tmax + i % kBlockLanes) < 0.f);
    add_to_owners(wide::Rgb::load(light_, i), arrives, destination + i, radiance);
  });
}

}  // namespace kinome::transport
