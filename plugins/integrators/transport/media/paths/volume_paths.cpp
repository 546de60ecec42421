#include "transport/media/paths/volume_paths.h"

#include <algorithm>
#include <numeric>

#include "kinome/wide/functions.h"
#include "kinome/wide/surface_point.h"
#include "transport/camera/camera.h"
#include "transport/media/tracking/channels.h"
#include "transport/media/tracking/roulette.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Paths of more steps than this become rarer (weight_of_length()).
constexpr float kLongPathSteps = 1024;

/// Maximum probability of surviving Russian roulette at surfaces.
float max_survival_at_surfaces() {
  return survival_probability(kinome::Rgb(1.f));
}

}  // namespace

VolumePaths::State VolumePaths::make_state(Arena& arena) {
  return {arena.indices(), arena.indices(), arena.three(), arena.floats(),
          arena.three(),   arena.floats(),  arena.floats()};
}

VolumePaths::VolumePaths(const SceneTable& scene, const MediaTable& media, const Sampler& sampler,
                         const PathSettings& settings, size_t rays, LightChoice* choice)
    : scene_(scene),
      media_(media),
      sampler_(sampler),
      length_(settings.length),
      hides_emitters_(settings.hide_emitters),
      numbers_(rays),
      segments_(scene, media, settings.hide_emitters, rays),
      walks_(scene, media, settings.length, rays),
      shadows_(scene, media, Surfaces::max_points(scene, rays), rays),
      met_(scene, rays),
      emitters_(scene, Surfaces::max_points(scene, rays)),
      choice_(choice),
      sort_(Surfaces::max_points(scene, rays)),
      per_ray_(rays),
      rays_(per_ray_.ray_hits()),
      along_(make_state(per_ray_)),
      u_(per_ray_.floats()),
      optical_depth_(per_ray_.floats()),
      channel_(media.is_coloured() ? per_ray_.indices() : nullptr),
      missed_pdf_(per_ray_.floats()),
      missed_d_(per_ray_.three()),
      missed_light_(per_ray_.three()),
      per_point_(Surfaces::max_points(scene, rays)),
      at_(make_state(per_point_)),
      emitter_weight_(per_point_.floats()),
      pdf_factor_(per_point_.floats()),
      relative_index2_(per_point_.floats()),
      max_survival_(per_point_.floats()),
      wo_(per_point_.three()),
      d_(per_point_.three()),
      light_(per_point_.three()),
      carried_(per_point_.three()),
      u1_(per_point_.floats()),
      pdf_(per_point_.floats()),
      distance_(per_point_.floats()),
      u2_(per_point_.two()),
      medium_(per_point_.indices()),
      destination_(per_point_.indices()),
      answer_(make_answer(per_point_)),
      sampled_{per_point_.three(), per_point_.floats(), per_point_.floats(), per_point_.three(),
               per_point_.floats()},
      weight_pdf_(per_point_.floats()),
      shadow_rays_(per_point_.untraced_rays()) {}

void VolumePaths::trace(const PixelSamples& samples, const RayHit16* camera_rays,
                        const Columns3& radiance, float* alpha, RenderCounters& counters) {
  const bool sees_sky = scene_.scene().environment() && !hides_emitters_;
  std::fill_n(alpha, samples.count(), sees_sky ? 1.f : 0.f);
  begin(samples, camera_rays);
  first_share_ = 0;
  later_ = nullptr;
  reference_ = nullptr;
  trace_on(samples, kCameraDimensions, radiance, alpha, counters);
}

void VolumePaths::trace_from(const PixelSamples& samples, size_t count, float share,
                             uint32_t dimension, float* reference, const Columns3& radiance,
                             RenderCounters& counters, EdgeTracer* later) {
  later_ = later;
  reference_ = reference;
  count_ = count;
  for_lanes(count_, [&](size_t i) {
    Float(0.f).store(along_.scatterings + i);
    Float(kInfinity).store(along_.pdf + i);
    Float(1.f).store(along_.index2 + i);
  });
  first_share_ = share;
  trace_on(samples, dimension, radiance, nullptr, counters);
}

/// Traces the paths to their ends. Sets alpha unless it is nullptr.
void VolumePaths::trace_on(const PixelSamples& samples, uint32_t dimension,
                           const Columns3& radiance, float* alpha, RenderCounters& counters) {
  RayKind kind = RayKind::kCamera;
  uint32_t steps = 1;
  for (uint32_t first = dimension; count_ > 0; first += kStepDimensions, ++steps) {
    {
      const StageTimer timer(
          counters.stage_seconds[kind == RayKind::kCamera ? "primary" : "bounce"]);
      const bool is_later = later_ && kind != RayKind::kCamera;
      if (is_later) {
        const FirstEdges edges{rays_, along_.owner, along_.medium, along_.throughput,
                               along_.scatterings};
        later_->trace(samples, edges, count_, first, radiance, counters);
      } else if (first_share_ == 0) {
        trace_edges(samples, first, kind, counters);
      }
      if (is_later || first_share_ == 0) walk(RandomSeeds(samples, first), alpha, counters);
      find_points();
      add_emission(radiance);
      add_environment(radiance);
    }
    kind = RayKind::kBsdf;
    if (met_.reflecting() == 0) return set_alpha(alpha);
    const uint32_t emitter = first + kEdgeDimensions;
    {
      const StageTimer timer(counters.stage_seconds["shade"]);
      sample(samples, emitter);
    }
    add_emitter_samples(RandomSeeds(samples, emitter), radiance, counters);
    const StageTimer timer(counters.stage_seconds["shade"]);
    scatter(samples, emitter + EmitterSamples::kDimensions, steps, alpha);
    sort_rays();
    if (!later_) first_share_ = 0;
  }
}

/// Traces the rays to their next points.
void VolumePaths::trace_edges(const PixelSamples& samples, uint32_t dimension, RayKind kind,
                              RenderCounters& counters) {
  sample_distances(samples, dimension);
  const PathState state{along_.owner,   along_.medium, along_.throughput,
                        optical_depth_, channel_,      along_.scatterings};
  segments_.trace(rays_, count_, state, RandomSeeds(samples, dimension), kind, counters);
}

/// Continues the paths that collide in enclosed media to the next surface.
void VolumePaths::walk(const RandomSeeds& seeds, float* alpha, RenderCounters& counters) {
  if (!media_.has_walks()) return;
  const PathState state{along_.owner,   along_.medium, along_.throughput,
                        optical_depth_, channel_,      along_.scatterings};
  walks_.walk(rays_, count_, state, {along_.index2, along_.from, along_.pdf, alpha},
              seeds.after(kMaxLegs + 1), counters);
}

/// Rays begin at the near clip distance, as in Mitsuba.
VolumePaths::FirstEdges VolumePaths::begin(const PixelSamples& samples,
                                           const RayHit16* camera_rays) {
  count_ = samples.count();
  for_lanes(count_, [&](size_t i) {
    const Ray16& from = camera_rays[i / kBlockLanes].ray;
    Ray16& to = rays_[i / kBlockLanes].ray;
    const size_t lane = i % kBlockLanes;
    const Columns3 o(const_cast<float*>(from.ox), const_cast<float*>(from.oy),
                     const_cast<float*>(from.oz));
    const Columns3 d(const_cast<float*>(from.dx), const_cast<float*>(from.dy),
                     const_cast<float*>(from.dz));
    const wide::Vec3 direction = wide::Vec3::load(d, lane);
    const Float near = Float::load(from.tmin + lane);
    const wide::Vec3 origin = wide::Vec3::load(o, lane) + direction * near;
    origin.store({to.ox, to.oy, to.oz}, lane);
    direction.store({to.dx, to.dy, to.dz}, lane);
    (Float::load(from.tmax + lane) - near).store(to.tmax + lane);
    (iota() + static_cast<int32_t>(i)).store(along_.owner + i);
    Int(static_cast<int32_t>(media_.start())).store(along_.medium + i);
    wide::Vec3(1.f).store(along_.throughput, i);
    Float(0.f).store(along_.scatterings + i);
    origin.store(along_.from, i);
    Float(kInfinity).store(along_.pdf + i);
    Float(1.f).store(along_.index2 + i);
  });
  return {rays_, along_.owner, along_.medium, along_.throughput, along_.scatterings};
}

/// Samples the optical depths at which the rays collide, in a channel drawn by the throughput.
void VolumePaths::sample_distances(const PixelSamples& samples, uint32_t dimension) {
  if (media_.size() == 1) return;
  numbers_.fill_1d(sampler_, samples, dimension, along_.owner, count_, u_);
  for_lanes(count_, [&](size_t i) { (-log(1.f - Float::load(u_ + i))).store(optical_depth_ + i); });
  if (!channel_) return;
  numbers_.fill_1d(sampler_, samples, dimension + 1, along_.owner, count_, u_);
  for_lanes(count_, [&](size_t i) {
    draw_channel(wide::Rgb::load(along_.throughput, i), Float::load(u_ + i)).store(channel_ + i);
  });
}

/// Finds the points at the ends of the rays, and their paths.
void VolumePaths::find_points() {
  met_.find(rays_, count_, Surfaces::Which::kAll);
  const uint32_t* const ray = met_.points().ray;
  for_lanes(met_.points().count, [&](size_t i) {
    const Int k = Int::load(ray + i);
    gather(along_.owner, k).store(at_.owner + i);
    gather(along_.medium, k).store(at_.medium + i);
    gather(along_.throughput, k).store(at_.throughput, i);
    gather(along_.scatterings, k).store(at_.scatterings + i);
    gather(along_.from, k).store(at_.from, i);
    gather(along_.pdf, k).store(at_.pdf + i);
    gather(along_.index2, k).store(at_.index2 + i);
  });
}

/// Samples emitters and directions at the points.
void VolumePaths::sample(const PixelSamples& samples, uint32_t dimension) {
  const SurfaceBlock& points = met_.points();
  const size_t count = met_.reflecting(), scattering = met_.scattering();
  for (const Surfaces::Range& range : met_.ranges()) {
    const uint32_t medium = medium_of(range);
    const bool is_medium = medium != MediaTable::kVacuum;
    const bool is_first = is_found_elsewhere(range);
    const float weight = is_medium ? media_.emitter_weight(medium) : 1.f;
    const bool finds_scattered = choice_ && choice_->has_scattered_light();
    const size_t first = range.first, padded_count = padded(range.count);
    std::fill_n(emitter_weight_ + first, padded_count, is_first && !finds_scattered ? 0.f : weight);
    std::fill_n(pdf_factor_ + first, padded_count,
                !(weight > 0) ? 0.f
                : is_first    ? 1 / first_share_
                : choice_     ? emitters_.pick_pdf() / (is_medium ? LightChoice::kMediumShare : 1)
                              : 1.f);
    std::fill_n(relative_index2_ + first, padded_count, sqr(range.row->bsdf->relative_index()));
    std::fill_n(max_survival_ + first, padded_count,
                is_medium && media_.ends(medium) ? 1.f : max_survival_at_surfaces());
  }
  BsdfQuery query;
  if (scattering > 0) {
    sample_emitters(samples, dimension, scattering);
    for_lanes(scattering, [&](size_t i) {
      frame_at(points, i).to_local(wide::Vec3::load(light().d, i)).store(wo_, i);
    });
    query.wo = wo_;
  }
  const uint32_t bsdf = dimension + EmitterSamples::kDimensions;
  numbers_.fill_1d(sampler_, samples, bsdf, at_.owner, count, u1_);
  numbers_.fill_2d(sampler_, samples, bsdf + 1, at_.owner, count, u2_);
  query.u1 = u1_;
  query.u2 = u2_;
  shade(met_, query, answer_);
  for (const Surfaces::Range& range : met_.ranges()) {
    const size_t first = range.first, padded_count = padded(range.count);
    if (first >= count) break;
    if (!choice_ || !is_found_elsewhere(range)) continue;
    choice_->redirect(sampler_, samples, dimension, points.part(first, padded_count),
                      medium_of(range), at_.owner + first, padded_count, numbers_, u1_ + first,
                      u2_.from(first), answer_.from(first));
  }
}

/// Medium of collisions; MediaTable::kVacuum for surfaces.
uint32_t VolumePaths::medium_of(const Surfaces::Range& range) const {
  if (range.row->shape) return MediaTable::kVacuum;
  return static_cast<uint32_t>(range.row - scene_.rows().data()) + 1;
}

/// Sets the media that light from directions d, or toward them, is in.
void VolumePaths::find_media(size_t count, const Columns3& d, uint32_t* medium) const {
  for (const Surfaces::Range& range : met_.ranges()) {
    const size_t first = range.first, end = first + padded(range.count);
    if (first >= count) return;
    const Shape* const shape = range.row->shape;
    if (!shape || !shape->separates_media()) {
      std::copy(at_.medium + first, at_.medium + end, medium + first);
      continue;
    }
    const uint32_t k = rays_[met_.points().ray[first] / 16].shape[met_.points().ray[first] % 16];
    const Int inside(static_cast<int32_t>(media_.interior(k)));
    const Int outside(static_cast<int32_t>(media_.exterior(k)));
    for_lanes(end - first, [&](size_t lane) {
      const size_t i = first + lane;
      const Float cosine = dot(wide::Vec3::load(met_.points().n, i), wide::Vec3::load(d, i));
      select(cosine > 0.f, outside, inside).store(medium + i);
    });
  }
}

/// Factor of State::index2 where sampled directions go through the surface.
Float VolumePaths::index2_factor(size_t i) const {
  const Float from = Float::load(met_.points().wi.z + i), to = Float::load(answer_.wo.z + i);
  const Mask goes_through = (from * to < 0.f) & !(Float::load(answer_.is_delta + i) == kNullSample);
  const Float factor = Float::load(relative_index2_ + i);
  return select(goes_through, select(from > 0.f, factor, 1.f / factor), Float(1.f));
}

/// Adds the throughputs behind the first surfaces to the references of their samples.
void VolumePaths::add_to_reference() {
  const SurfaceBlock& points = met_.points();
  for (size_t i = 0; i < met_.reflecting(); ++i) {
    const bool is_surface = points.n.at(i) != kinome::Vec3(0.f);
    if (!is_surface || at_.scatterings[i] > 0 || !(met_.live()[i] > 0)) continue;
    if (!(answer_.sample_pdf[i] > 0) || answer_.is_delta[i] == kNullSample) continue;
    const kinome::Rgb carried = at_.throughput.at(i) * answer_.weight.at(i);
    reference_[at_.owner[i]] += (carried.x + carried.y + carried.z) * (1 / 3.f);
  }
}

/// Probability that roulette keeps a path. In proportion to its throughput relative to that of all
/// paths of its sample, since a path of small weight isn't worth its time; absolute throughputs
/// would end the paths of dark pixels. `is_late`: beyond the number of points from which all paths
/// must end at some time. `weight`: of paths of this length.
Float VolumePaths::survival(size_t i, const wide::Rgb& carried, Float weight, Mask is_late) const {
  const Float most = select(is_late, Float::load(max_survival_ + i), Float(1.f));
  if (!reference_) return select(is_late, min(max_component(carried) / weight, most), Float(1.f));
  const Float all = gather(reference_, Int::load(at_.owner + i));
  const Float relative = max_component(carried) / max(all, Float(1e-20f));
  return min(relative * survival_gain_ / weight, most);
}

/// Scatters the paths of `steps` steps: makes their next rays, some of which are inactive.
void VolumePaths::scatter(const PixelSamples& samples, uint32_t dimension, uint32_t steps,
                          float* alpha) {
  const SurfaceBlock& points = met_.points();
  const size_t count = met_.reflecting();
  numbers_.fill_1d(sampler_, samples, dimension + kBsdfDimensions, at_.owner, count, u1_);
  if (reference_) add_to_reference();
  const Float max_depth = static_cast<float>(length_.max_depth);
  const Float rr_depth = static_cast<float>(length_.rr_depth);
  const Float weight = weight_of_length(static_cast<float>(steps), kLongPathSteps);
  for_lanes(count, [&](size_t i) {
    frame_at(points, i).to_world(wide::Vec3::load(answer_.wo, i)).store(d_, i);
    const Float is_delta = Float::load(answer_.is_delta + i);
    const Mask is_straight = is_delta == kNullSample;
    wide::Rgb carried = wide::Rgb::load(at_.throughput, i) * wide::Rgb::load(answer_.weight, i);
    const Float before = Float::load(at_.scatterings + i);
    const Float scatterings = before + select(is_straight, Float(0.f), Float(1.f));
    Mask on = (Float::load(met_.live() + i) > 0.f) & !(Float::load(answer_.sample_pdf + i) <= 0.f) &
              (scatterings < max_depth);
    const Float index2 = Float::load(at_.index2 + i) * index2_factor(i);
    index2.store(at_.index2 + i);
    const Mask is_late = scatterings > rr_depth;
    const Float survives = survival(i, carried * index2, weight, is_late);
    const Mask is_chosen = (reference_ ? Mask(survives < 1.f) : is_late) & !is_straight;
    on &= (Float::load(u1_ + i) < survives) | !is_chosen;
    carried = select(is_chosen, carried / survives, carried);
    carried = select(on, carried);
    carried.store(carried_, i);
    on &= !is_black(carried);
    const Float factor = Float::load(pdf_factor_ + i);
    const Mask is_alone = (is_delta > 0.f) | !(factor > 0.f);
    const Float pdf =
        select(is_alone, Float(kInfinity), Float::load(answer_.sample_pdf + i) * factor);
    select(is_straight, Float::load(at_.pdf + i), pdf).store(at_.pdf + i);
    select(is_straight, wide::Vec3::load(at_.from, i), wide::Vec3::load(points.p, i))
        .store(at_.from, i);
    scatterings.store(at_.scatterings + i);
    write_shadow_rays(points, i, wide::Vec3::load(d_, i), Float(kInfinity), on, false,
                      shadow_rays_);
  });
  set_alpha(alpha);
  find_media(count, d_, medium_);
}

/// Sets alpha to 1 for paths that the points scatter or absorb.
void VolumePaths::set_alpha(float* alpha) const {
  if (!alpha) return;
  const float* const live = met_.live();
  for (const Surfaces::Range& range : met_.ranges()) {
    // Collisions count only if the path may continue, as in Mitsuba.
    const float end = range.row->shape ? kInfinity : static_cast<float>(length_.max_depth);
    const bool reflects = range.first < met_.reflecting();
    for (size_t i = range.first; i < range.first + range.count; ++i) {
      const bool is_scattered = !reflects || (at_.scatterings[i] > 0 && at_.scatterings[i] < end);
      if (live[i] > 0 && is_scattered) alpha[at_.owner[i]] = 1;
    }
  }
}

/// Compacts the active rays, and their paths.
void VolumePaths::sort_rays() {
  count_ = sort_.sort(shadow_rays_, met_.reflecting());
  if (count_ == 0) return;
  sort_.copy(&rays_[0].ray, sizeof(RayHit16));
  for_lanes(count_, [&](size_t k) {
    const Int i = Int::load(sort_.order() + k);
    gather(at_.owner, i).store(along_.owner + k);
    gather(medium_, i).store(along_.medium + k);
    gather(carried_, i).store(along_.throughput, k);
    gather(at_.scatterings, i).store(along_.scatterings + k);
    gather(at_.from, i).store(along_.from, k);
    gather(at_.pdf, i).store(along_.pdf + k);
    gather(at_.index2, i).store(along_.index2 + k);
  });
}

}  // namespace kinome::transport
