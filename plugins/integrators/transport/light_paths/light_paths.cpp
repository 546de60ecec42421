#include "transport/light_paths/light_paths.h"

#include <algorithm>

#include "kinome/wide/surface_point.h"
#include "transport/light_paths/adjoint.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Maximum number of points on emitters or on surfaces.
size_t max_points(const SceneTable& scene, size_t samples) {
  return std::max(Emission::max_rays(scene, samples), Surfaces::max_points(scene, samples));
}

}  // namespace

LightPaths::State LightPaths::make_state(Arena& arena) {
  return {arena.indices(), arena.three(), arena.floats()};
}

LightPaths::LightPaths(const SceneTable& scene, const Sensor& sensor, const PathLength& length,
                       bool hide_emitters, size_t samples)
    : scene_(scene),
      sensor_(sensor),
      length_(length),
      hide_emitters_(hide_emitters),
      numbers_(samples),
      emission_(scene, samples),
      met_(scene, samples),
      arena_(max_points(scene, samples)),
      splats_(sensor, arena_.capacity()),
      emitting_(arena_.points()),
      light_(arena_.three()),
      seen_from_(arena_.three()),
      u1_(arena_.floats()),
      u2_(arena_.two()),
      next_(arena_.capacity()),
      seen_(make_answer(arena_)),
      from_(make_state(arena_)),
      at_(make_state(arena_)),
      rays_(arena_.rays()),
      sort_(arena_.capacity()),
      traced_(arena_.ray_hits()) {}

/// Connects points on surfaces that emit to the lens.
void LightPaths::connect_emitters(const PixelSamples& samples, RenderCounters& counters) {
  splats_.choose_lens(samples, emission_.owner(), emission_.count(), Emission::kDimensions,
                      numbers_);
  for (const Emission::Range& range : emission_.ranges()) {
    if (range.emitter->is_surface()) {
      connect_emitter(range, counters);
    } else {
      for (size_t i = range.first; i < range.first + padded(range.count); ++i) {
        splats_.rays()[i / kBlockLanes].tmax[i % kBlockLanes] = -1;
      }
    }
  }
}

void LightPaths::connect_emitter(const Emission::Range& range, RenderCounters& counters) {
  const size_t first = range.first, end = first + padded(range.count);
  const Shape& shape = *range.emitter->shape();
  const SurfaceBlock points = emitting_.part(first, range.count);
  std::fill_n(points.shape, padded(range.count), &shape);
  shape.sample_surface_block(emission_.place().from(first), points);
  splats_.connect(emitting_.p, first, range.count);
  const ConnectionBlock& seen = splats_.seen();
  for (size_t i = first; i < end; i += kLanes) {
    frame_at(emitting_, i).to_local(wide::Vec3::load(seen.d, i)).store(emitting_.wi, i);
  }
  range.emitter->eval_surface_block(points, {}, light_.from(first), nullptr);
  const Float area_and_pick = shape.area() * emission_.emitters();
  for (size_t i = first; i < end; i += kLanes) {
    const wide::Vec3 d = wide::Vec3::load(seen.d, i);
    const Float weight = Float::load(seen.weight + i);
    const Float cosine = abs(dot(wide::Vec3::load(emitting_.n, i), d));
    const wide::Rgb value = wide::Rgb::load(light_, i) * (cosine * area_and_pick * weight);
    const Mask on = Float::load(emission_.live() + i) > 0.f && weight > 0.f && !is_black(value);
    counters[RayKind::kShadow] += wide::count(on);
    value.store(splats_.value(), i);
    write_shadow_rays(emitting_, i, d, Float::load(seen.distance + i), on, true, splats_.rays());
  }
}

/// Samples the first edges.
void LightPaths::emit(const PixelSamples& samples) {
  emission_.sample(sensor_.sampler(), samples, numbers_);
  std::copy_n(emission_.owner(), emission_.count(), from_.owner);
  const EmissionBlock& light = emission_.rays();
  for_lanes(emission_.count(), [&](size_t i) {
    const wide::Rgb power = wide::Rgb::load(light.power, i) * Float(emission_.emitters());
    const Float largest = max_component(power);
    const Mask on = Float::load(emission_.live() + i) > 0.f && largest > 0.f;
    power.store(from_.power, i);
    (1.f / largest).store(from_.inverse_emitted + i);
    Ray16& ray = rays_[i / kBlockLanes];
    const size_t lane = i % kBlockLanes;
    wide::Vec3::load(light.o, i).store({ray.ox, ray.oy, ray.oz}, lane);
    wide::Vec3::load(light.d, i).store({ray.dx, ray.dy, ray.dz}, lane);
    Float(0.f).store(ray.tmin + lane);
    select(on, kInfinity, -1.f).store(ray.tmax + lane);
  });
}

/// Traces the sorted rays and finds the points that they hit.
void LightPaths::find_points(Tile& tile) {
  const size_t on = sort_.on();
  clear_hits(traced_, on);
  sort_.copy(&traced_[0].ray, sizeof(RayHit16));
  scene_.scene().intersect(traced_, padded(on) / kBlockLanes, Coherence::kIncoherent,
                           tile.counters);
  tile.counters[RayKind::kLight] += on;
  met_.find(traced_, on, Surfaces::Which::kAll);
  const uint32_t* const ray = met_.points().ray;
  for_lanes(met_.reflecting(), [&](size_t i) {
    const Int from = as_int(gather(sort_.order(), Int::load(ray + i)));
    gather(from_.owner, from).store(at_.owner + i);
    gather(from_.power, from).store(at_.power, i);
    gather(from_.inverse_emitted, from).store(at_.inverse_emitted + i);
  });
}

/// Connects surface points to the lens.
void LightPaths::connect_points(const PixelSamples& samples, uint32_t dimension,
                                RenderCounters& counters) {
  const SurfaceBlock& points = met_.points();
  const size_t count = met_.scattering();
  splats_.choose_lens(samples, at_.owner, count, dimension, numbers_);
  splats_.connect(points.p, 0, count);
  const ConnectionBlock& seen = splats_.seen();
  for_lanes(count, [&](size_t i) {
    frame_at(points, i).to_local(wide::Vec3::load(seen.d, i)).store(seen_from_, i);
  });
  shade(met_, seen_from_, {.wo = points.wi}, seen_);
  for_lanes(count, [&](size_t i) {
    const wide::Vec3 n = wide::Vec3::load(points.n, i), d = wide::Vec3::load(seen.d, i);
    const wide::Vec3 from = frame_at(points, i).to_world(wide::Vec3::load(points.wi, i));
    const Float weight = Float::load(seen.weight + i);
    const Float factor = adjoint_factor(dot(n, from), dot(n, d)) * weight;
    const wide::Rgb f = wide::Rgb::load(seen_.f, i) * factor;
    const Mask is_seen = Float::load(met_.live() + i) > 0.f && weight > 0.f;
    const Mask on = is_seen & !is_black(f);
    counters[RayKind::kShadow] += wide::count(on);
    counters.skipped_shadow_rays += wide::count(is_seen & !on);
    (wide::Rgb::load(at_.power, i) * f).store(splats_.value(), i);
    write_shadow_rays(points, i, d, Float::load(seen.distance + i), on, true, splats_.rays());
  });
}

/// Sets the rays of the next edges.
void LightPaths::write_rays(const BsdfAnswer& sampled, bool plays_roulette) {
  const SurfaceBlock& points = met_.points();
  for_lanes(met_.reflecting(), [&](size_t i) {
    wide::Rgb power = wide::Rgb::load(at_.power, i) * wide::Rgb::load(sampled.weight, i);
    const Float inverse = Float::load(at_.inverse_emitted + i);
    Mask on = Float::load(met_.live() + i) > 0.f && Float::load(sampled.sample_pdf + i) > 0.f &&
              max_component(power) > 0.f;
    if (plays_roulette) {
      const Float survival = survival_probability(power * inverse);
      on &= Float::load(u1_ + i) < survival;
      power = power / survival;
    }
    power.store(at_.power, i);
    const wide::Vec3 to = frame_at(points, i).to_world(wide::Vec3::load(sampled.wo, i));
    write_shadow_rays(points, i, to, Float(kInfinity), on, false, rays_);
  });
}

void LightPaths::scatter(const PixelSamples& samples, uint32_t depth, uint32_t dimension) {
  const Sampler& sampler = sensor_.sampler();
  const size_t count = met_.reflecting();
  numbers_.fill_1d(sampler, samples, dimension + 2, at_.owner, count, u1_);
  numbers_.fill_2d(sampler, samples, dimension + 3, at_.owner, count, u2_);
  const BsdfAnswer& sampled = next_.sample(met_, u1_, u2_);
  const bool plays_roulette = depth >= length_.rr_depth;
  if (plays_roulette) numbers_.fill_1d(sampler, samples, dimension + 5, at_.owner, count, u1_);
  write_rays(sampled, plays_roulette);
  std::swap(from_, at_);
}

void LightPaths::trace(const PixelSamples& samples, Tile& tile) {
  const Scene& scene = scene_.scene();
  RenderCounters& counters = tile.counters;
  const bool shows_emitters = !hide_emitters_ && scene.has_surface_emitters();
  size_t on = 0;
  {
    const StageTimer timer(counters.stage_seconds["emit"]);
    emission_.pick(sensor_.sampler(), samples, numbers_);
    if (shows_emitters) connect_emitters(samples, counters);
    if (length_.max_depth > 1) {
      emit(samples);
      on = sort_.sort(rays_, emission_.count());
    }
  }
  if (shows_emitters) splats_.trace(scene, emission_.count(), tile);
  for (uint32_t depth = 1; on > 0; ++depth) {
    const uint32_t dimension = kEmissionDimensions + kPointDimensions * (depth - 1);
    const bool is_last = depth + 2 > length_.max_depth;
    {
      const StageTimer timer(counters.stage_seconds["bounce"]);
      find_points(tile);
    }
    {
      const StageTimer timer(counters.stage_seconds["shade"]);
      connect_points(samples, dimension, counters);
      if (!is_last) scatter(samples, depth, dimension);
      on = is_last ? 0 : sort_.sort(rays_, met_.reflecting());
    }
    splats_.trace(scene, met_.scattering(), tile);
  }
}

}  // namespace kinome::transport
