#include "direct_light.h"

#include <algorithm>

#include "kinome/wide/surface_point.h"
#include "path_parameters.h"
#include "rays.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Weight of a sample from a technique of density a if another technique has density b. The ratio
/// avoids overflow and 0 / 0 (a is positive).
template <class F>
KINOME_WIDE F power_heuristic(F a, F b) {
  const F ratio = b / a;
  return 1.f / (1.f + ratio * ratio);
}

KINOME_WIDE Mask is_live(const Surfaces& surfaces, size_t i) {
  return Float::load(surfaces.live() + i) > 0.f;
}

KINOME_WIDE wide::Rgb throughput(const Vertices& vertices, size_t i) {
  return vertices.throughput.x ? wide::Rgb::load(vertices.throughput, i) : wide::Rgb(1.f);
}

}  // namespace

DirectLight::Traced::Traced(const SceneTable& scene, size_t most_points, size_t most_rays)
    : sort(most_points),
      per_ray(most_rays),
      rays(per_ray.ray_hits()),
      met{{scene, most_rays}, {scene, most_rays}} {}

DirectLight::Passing::Passing(const SceneTable& scene, size_t most_points, size_t most_rays)
    : shadows(scene, most_points, most_rays),
      per_point(most_points),
      next{per_point.three(), per_point.floats(), per_point.floats()},
      max_passes(per_point.floats()),
      through{per_point.three(), per_point.floats()} {}

DirectLight::DirectLight(const SceneTable& scene, const Sampler& sampler, const LightSamples& count,
                         size_t rays)
    : scene_(scene),
      sampler_(sampler),
      count_(count),
      most_rays_(rays),
      most_points_(Surfaces::most_points(scene, rays)),
      numbers_(rays),
      arena_(most_points_),
      emitters_(scene, most_points_),
      occlusion_(most_points_, rays),
      wo_(arena_.three()),
      u1_(arena_.floats()),
      u2_(arena_.two()),
      answer_(make_answer(arena_)),
      carried_(arena_.three()),
      light_(arena_.three()),
      rays_(arena_.untraced_rays()),
      d_(arena_.three()),
      per_met_(most_points_),
      from_p_(per_met_.three()),
      met_light_(per_met_.three()),
      met_pdf_(per_met_.floats()) {}

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
  if (!passing_) passing_ = std::make_unique<Passing>(scene_, most_points_, most_rays_);
  const Surfaces& surfaces = *vertices.surfaces;
  for (const Surfaces::Range& range : surfaces.ranges()) {
    if (!range.row->bsdf->passes_straight()) continue;
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
    select(passes > static_cast<float>(kMaxPasses), max(pdf, Float(kBeyondPasses)), pdf)
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

/// Weight of emitter samples i … of density pdf. `passed` is the probability that a BSDF sample
/// goes straight through the surfaces between.
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
    put_shadow_rays(surfaces.points(), i, wide::Vec3::load(sampled.d, i),
                    Float::load(sampled.distance + i), on, true, rays_);
  });
  counters[RayKind::kShadow] += rays;
  counters.skipped_shadow_rays += surfaces.live_reflecting() - rays;
  return rays;
}

void DirectLight::add_emitter_samples(const Vertices& vertices, const Columns3& radiance,
                                      RenderCounters& counters) {
  const Surfaces& surfaces = *vertices.surfaces;
  make_emitter_rays(vertices, counters,
                    [&](size_t i, const Float& pdf) { return emitter_weight(i, pdf, 1.f); });
  // A single delta emitter lights neighbouring pixels from similar directions: rays stay unsorted.
  const bool are_neighbours = !vertices.throughput.x && emitters_.come_from_one_place();
  add_arriving(vertices, surfaces.scattering(), are_neighbours, radiance, counters);
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
  for_lanes(count, [&](size_t i) {
    const wide::Rgb transmittance = wide::Rgb::load(shadows.transmittance(), i);
    const Mask arrives = !is_black(transmittance);
    if (none(arrives)) return;
    const Float passes = Float::load(shadows.passes() + i);
    const Float weight = emitter_weight(i, emitter_pdf(i), Float::load(shadows.probability() + i));
    const wide::Rgb arriving = wide::Rgb::load(light_, i) * transmittance * weight;
    const Mask few = passes <= light.few_passes;
    add_to_owners(arriving, arrives & few, vertices.owner + i, light.radiance);
    add_to_owners(arriving, arrives & !few, vertices.owner + i, light.beyond);
  });
}

/// Traces the first `count` rays of rays_ and adds light_ of those that arrive.
void DirectLight::add_arriving(const Vertices& vertices, size_t count, bool are_neighbours,
                               const Columns3& radiance, RenderCounters& counters) {
  const StageTimer timer(counters.stage_seconds["shadow"]);
  if (are_neighbours) {
    Occlusion::trace_in_place(scene_.scene(), rays_, count, counters);
  } else {
    occlusion_.trace(scene_.scene(), rays_, count, counters);
  }
  for_lanes(count, [&](size_t i) {
    const Mask arrives = !(Float::load(rays_[i / kBlockLanes].tmax + i % kBlockLanes) < 0.f);
    add_to_owners(wide::Rgb::load(light_, i), arrives, vertices.owner + i, radiance);
  });
}

void DirectLight::find_directions(const Vertices& vertices) {
  const SurfaceBlock& points = vertices.surfaces->points();
  for_lanes(vertices.surfaces->reflecting(), [&](size_t i) {
    frame_at(points, i).to_world(wide::Vec3::load(answer_.wo, i)).store(d_, i);
  });
}

/// Adds the environment's light where BSDF rays leave the scene. Testing occlusion is enough if no
/// surface emits.
void DirectLight::add_environment(const Vertices& vertices, const Columns3& radiance,
                                  RenderCounters& counters) {
  const Surfaces& surfaces = *vertices.surfaces;
  const size_t count = surfaces.reflecting();
  size_t rays = 0;
  {
    const StageTimer timer(counters.stage_seconds["shade"]);
    find_directions(vertices);
    scene_.scene().environment()->eval_environment_block(d_, count, met_light_,
                                                         count_.emitter > 0 ? met_pdf_ : nullptr);
    for (size_t i = 0; vertices.shown_share && i < count; ++i) {
      if (is_shown(vertices, i)) met_light_.set(i, met_light_.at(i) * shown_share(vertices, i));
    }
    for (size_t i = 0; vertices.straight && i < count; ++i) {
      if (vertices.straight[vertices.owner[i]] > 0) met_light_.set(i, kinome::Rgb(0.f));
    }
    const float n_emitter = static_cast<float>(count_.emitter) * emitters_.pick_pdf();
    const float n_bsdf = static_cast<float>(count_.bsdf);
    const bool has_origins = vertices.origins.pdf;
    const float* const pdfs = has_origins ? passing_->next.pdf : answer_.sample_pdf;
    for_lanes(count, [&](size_t i) {
      Float weight = 1.f;
      if (count_.emitter > 0) {
        const Float pdf = Float::load(pdfs + i);
        const Mask is_alone =
            has_origins ? pdf >= kBeyondPasses : Float::load(answer_.is_delta + i) > 0.f;
        weight = select(is_alone, weight,
                        power_heuristic(pdf * n_bsdf, Float::load(met_pdf_ + i) * n_emitter));
      }
      const wide::Rgb carried = wide::Rgb::load(carried_, i);
      const wide::Rgb light = carried * wide::Rgb::load(met_light_, i) * weight;
      const Mask on = is_live(surfaces, i) & !is_black(carried) & !is_black(light);
      rays += wide::count(on);
      select(on, light).store(light_, i);
      put_shadow_rays(surfaces.points(), i, wide::Vec3::load(d_, i), Float(kInfinity), on, false,
                      rays_);
    });
  }
  counters[RayKind::kBsdf] += rays;
  counters.skipped_shadow_rays += surfaces.live_reflecting() - rays;
  add_arriving(vertices, count, false, radiance, counters);
}

void DirectLight::make_bsdf_rays(const Vertices& vertices, RenderCounters& counters) {
  const Surfaces& surfaces = *vertices.surfaces;
  const size_t count = surfaces.reflecting();
  find_directions(vertices);
  size_t valid = 0;
  for_lanes(count, [&](size_t i) {
    const Mask live = is_live(surfaces, i);
    valid += wide::count(live & !(Float::load(answer_.sample_pdf + i) <= 0.f) &
                         !is_black(wide::Rgb::load(answer_.weight, i)));
    put_shadow_rays(surfaces.points(), i, wide::Vec3::load(d_, i), Float(kInfinity),
                    live & !is_black(wide::Rgb::load(carried_, i)), false, rays_);
  });
  // With some lobes only, points without these need no ray.
  if (count_.lobes == Lobe::kAll) counters.skipped_shadow_rays += surfaces.live_reflecting() - valid;
}

void DirectLight::trace(const Vertices& vertices, Surfaces::Which which, const Columns3& radiance,
                        RenderCounters& counters) {
  size_t on = 0;
  {
    const StageTimer timer(counters.stage_seconds["shade"]);
    if (!traced_) traced_ = std::make_unique<Traced>(scene_, most_points_, most_rays_);
    make_bsdf_rays(vertices, counters);
    on = traced_->sort.sort(rays_, vertices.surfaces->reflecting());
    traced_->sort.copy(&traced_->rays[0].ray, sizeof(RayHit16));
    clear_hits(traced_->rays, on);
  }
  counters[RayKind::kBsdf] += on;
  const StageTimer timer(counters.stage_seconds["bounce"]);
  scene_.scene().intersect(traced_->rays, padded(on) / kBlockLanes, Coherence::kIncoherent,
                           counters);
  current_ = 1 - current_;
  traced_->met[current_].find(traced_->rays, on, which);
  add_met_surfaces(vertices, radiance);
  if (scene_.scene().environment()) add_met_environment(vertices, radiance);
  if (vertices.shown_share) update_shown_shares(vertices);
}

void DirectLight::update_shown_shares(const Vertices& vertices) const {
  const float* const live = vertices.surfaces->live();
  for (size_t i = 0; i < vertices.surfaces->reflecting(); ++i) {
    // Padding has a point's owner, but no valid sample.
    if (!(live[i] > 0) || answer_.is_delta[i] > 0) continue;
    const uint32_t owner = vertices.owner[i];
    vertices.shown_share[owner] = vertices.shown_share_later[owner];
  }
}

/// True if a delta lobe shows the light that the BSDF sample of a point finds.
bool DirectLight::is_shown(const Vertices& vertices, size_t point) const {
  if (vertices.origins.pdf) return passing_->next.pdf[point] == kInfinity;
  return answer_.is_delta[point] > 0;
}

float DirectLight::shown_share(const Vertices& vertices, size_t point) const {
  return vertices.shown_share ? vertices.shown_share[vertices.owner[point]] : 1.f;
}

float DirectLight::bsdf_weight(const Vertices& vertices, uint32_t point, float emitter_pdf) const {
  const bool has_origins = vertices.origins.pdf;
  const float share = is_shown(vertices, point) ? shown_share(vertices, point) : 1;
  const float pdf = has_origins ? passing_->next.pdf[point] : answer_.sample_pdf[point];
  const bool is_alone = has_origins ? pdf >= kBeyondPasses : answer_.is_delta[point] > 0;
  if (is_alone || count_.emitter == 0) return share;
  return share *
         power_heuristic(pdf * static_cast<float>(count_.bsdf),
                         emitter_pdf * emitters_.pick_pdf() * static_cast<float>(count_.emitter));
}

void DirectLight::add_met_surfaces(const Vertices& vertices, const Columns3& radiance) {
  const SurfaceBlock& met = this->met().points();
  const uint32_t* const from = traced_->sort.order();
  const Columns3& from_p = vertices.origins.pdf ? passing_->next.p : vertices.surfaces->points().p;
  for (const Surfaces::Range& range : this->met().ranges()) {
    if (!range.row->emitter) continue;
    const size_t first = range.first;
    for (size_t i = first; i < first + padded(range.count); ++i) {
      from_p_.set(i, from_p.at(from[met.ray[i]]));
    }
    range.row->emitter->eval_surface_block(met.part(first, range.count), from_p_.from(first),
                                           met_light_.from(first), met_pdf_ + first);
    for (size_t i = first; i < first + range.count; ++i) {
      const uint32_t k = from[met.ray[i]];
      const kinome::Rgb light = met_light_.at(i);
      if (is_black(light)) continue;
      const uint32_t owner = vertices.owner[k];
      radiance.set(owner, radiance.at(owner) +
                              carried_.at(k) * light * bsdf_weight(vertices, k, met_pdf_[i]));
    }
  }
}

void DirectLight::add_met_environment(const Vertices& vertices, const Columns3& radiance) {
  const auto missed = met().missed();
  const uint32_t* const from = traced_->sort.order();
  for (size_t i = 0; i < missed.size(); ++i) from_p_.set(i, d_.at(from[missed[i]]));
  scene_.scene().environment()->eval_environment_block(from_p_, missed.size(), met_light_,
                                                       count_.emitter > 0 ? met_pdf_ : nullptr);
  for (size_t i = 0; i < missed.size(); ++i) {
    const uint32_t k = from[missed[i]];
    const uint32_t owner = vertices.owner[k];
    if (vertices.straight && vertices.straight[owner] > 0) continue;
    const float weight = bsdf_weight(vertices, k, count_.emitter > 0 ? met_pdf_[i] : 0);
    radiance.set(owner, radiance.at(owner) + carried_.at(k) * met_light_.at(i) * weight);
  }
}

}  // namespace kinome::transport
