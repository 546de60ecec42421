#include "transport/media/tracking/segments.h"

#include <algorithm>
#include <cmath>

#include "kinome/wide/functions.h"
#include "transport/media/tracking/channels.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Numbers of paths `path[i]` ..., or i ... if `path` is nullptr.
KINOME_WIDE Int paths_at(const uint32_t* path, size_t i) {
  return path ? Int::load(path + i) : iota() + static_cast<int32_t>(i);
}

/// Stores values of paths `path[i]` ..., of which `count` are valid.
template <class T>
KINOME_WIDE void store_to(T value, const uint32_t* path, size_t i, size_t count, auto* column) {
  if (!path) return value.store(column + i);
  alignas(kColumnAlignment) std::remove_pointer_t<decltype(column)> values[kLanes];
  value.store(values);
  for (size_t lane = 0; lane < std::min(count, kLanes); ++lane)
    column[path[i + lane]] = values[lane];
}

}  // namespace

Segments::Segments(const SceneTable& scene, const MediaTable& media, bool hides_emitters,
                   size_t rays)
    : scene_(scene),
      media_(media),
      passed_row_of_(scene.rows().size(), static_cast<uint32_t>(scene.rows().size())),
      per_ray_(rays),
      far_(per_ray_.floats()),
      beyond_{per_ray_.ray_hits(), per_ray_.ray_hits()},
      path_{per_ray_.indices(), per_ray_.indices()},
      position_(per_ray_.indices()),
      met_(scene, rays),
      tracking_(media, rays) {
  const auto& shapes = scene.scene().shapes();
  for (size_t i = 0; i < shapes.size(); ++i) {
    const bool is_hidden = hides_emitters && shapes[i]->emitter();
    const bool is_boundary = shapes[i]->bsdf().is_invisible() && !shapes[i]->emitter();
    if (!is_hidden && !is_boundary) continue;
    passed_row_of_[i] = scene.row_of()[i];
    passes_ = true;
  }
}

void Segments::trace(RayHit16* rays, size_t count, const PathState& state, const RandomSeeds& seeds,
                     RayKind kind, RenderCounters& counters) {
  for_lanes(count, [&](size_t i) {
    Float::load(rays[i / kBlockLanes].ray.tmax + i % kBlockLanes).store(far_ + i);
  });
  trace_leg(rays, count, nullptr, state, seeds, kind, counters);
  if (!passes_) return;
  size_t left = pass(rays, count, nullptr, 0, state);
  for (uint32_t legs = 1; left > 0; ++legs) {
    if (legs > kMaxLegs) return drop(left, path_[(legs - 1) % 2], state);
    const int leg = (legs - 1) % 2;
    RayHit16* const beyond = beyond_[leg];
    const uint32_t* const path = path_[leg];
    trace_leg(beyond, left, path, state, seeds.after(legs), kind, counters);
    for (size_t i = 0; i < left; ++i) {
      copy_ray_hit(beyond, i, rays, path[i]);
      rays[path[i] / kBlockLanes].ray.tmin[path[i] % kBlockLanes] = 0;
    }
    left = pass(beyond, left, path, 1 - leg, state);
  }
}

/// Ends paths: their throughput becomes 0.
void Segments::drop(size_t count, const uint32_t* path, const PathState& state) {
  for (size_t i = 0; i < count; ++i) state.throughput.set(path[i], kinome::Rgb(0.f));
}

/// Traces rays to the next surface or collision. Ray i belongs to path path[i], or i if `path` is
/// nullptr.
void Segments::trace_leg(RayHit16* rays, size_t count, const uint32_t* path, const PathState& state,
                         const RandomSeeds& seeds, RayKind kind, RenderCounters& counters) {
  for_lanes(count, [&](size_t i) {
    const Int k = paths_at(path, i);
    float* const tmax = rays[i / kBlockLanes].ray.tmax + i % kBlockLanes;
    const Float far = gather(far_, k);
    (state.legs ? far : min(far, distance_to_collision(k, state))).store(tmax);
  });
  disable_padding(rays, count);
  clear_hits(rays, count);
  const bool is_camera = kind == RayKind::kCamera;
  scene_.scene().intersect(rays, padded(count) / kBlockLanes,
                           is_camera ? Coherence::kCoherent : Coherence::kIncoherent, counters);
  counters[kind] += count;
  if (state.legs) return list_legs(rays, count, path, state);
  set_collisions(rays, count, path, state);
  if (media_.has_grids()) track(rays, count, path, state, seeds);
}

/// Distance at which paths k collide if the medium doesn't end before.
Float Segments::distance_to_collision(Int k, const PathState& state) const {
  const Int medium = as_int(gather(state.medium, k));
  const Columns3 all = media_.extinction();
  const Float extinction = state.channel
                               ? component(gather(all, medium), as_int(gather(state.channel, k)))
                               : gather(all.x, medium);
  const Float optical_depth = gather(state.optical_depth, k);
  return select(extinction > 0.f, optical_depth / extinction, Float(kInfinity));
}

/// Turns rays that end before the next surface into collisions, and updates the paths.
void Segments::set_collisions(RayHit16* rays, size_t count, const uint32_t* path,
                              const PathState& state) const {
  const auto first = static_cast<uint32_t>(scene_.scene().shapes().size());
  for_lanes(count, [&](size_t i) {
    const Int k = paths_at(path, i);
    const Int medium = as_int(gather(state.medium, k));
    const Mask is_inside = medium > 0;
    if (none(is_inside)) return;
    RayHit16& block = rays[i / kBlockLanes];
    const size_t lane = i % kBlockLanes;
    const Mask hits = Uint::load(block.shape + lane) != kNoHit;
    const Float end = select(hits, Float::load(block.ray.tmax + lane),
                             min(gather(far_, k), media_.end_of_space(block.ray, lane, hits)));
    const Float collision = distance_to_collision(k, state);
    const Mask collides = is_inside & (collision < end);
    const Float travelled = select(is_inside, min(collision, end));
    wide::Rgb throughput = gather(state.throughput, k);
    const wide::Rgb albedo = gather(media_.albedo(), medium);
    Float extinction = gather(media_.extinction().x, medium);
    if (state.channel) {
      const Int channel = as_int(gather(state.channel, k));
      const wide::Rgb all = gather(media_.extinction(), medium);
      extinction = component(all, channel);
      throughput =
          throughput * select(is_inside,
                              segment_weight(throughput, all, albedo, channel, travelled, collides),
                              wide::Rgb(1.f));
    } else {
      throughput = throughput * select(collides, albedo, wide::Rgb(1.f));
    }
    const size_t valid = count - i;
    store_to(throughput.x, path, i, valid, state.throughput.x);
    store_to(throughput.y, path, i, valid, state.throughput.y);
    store_to(throughput.z, path, i, valid, state.throughput.z);
    const Float left = gather(state.optical_depth, k) - extinction * travelled;
    store_to(max(left, Float(0.f)), path, i, valid, state.optical_depth);
    select(collides, travelled, Float::load(block.ray.tmax + lane)).store(block.ray.tmax + lane);
    const Uint shape = as_uint(medium) + (first - 1);
    select(collides, shape, Uint::load(block.shape + lane)).store(block.shape + lane);
  });
}

/// Lists the parts of the rays in media, and multiplies throughputs by the transmittances.
void Segments::list_legs(const RayHit16* rays, size_t count, const uint32_t* path,
                         const PathState& state) const {
  for (size_t i = 0; i < count; ++i) {
    const uint32_t k = path ? path[i] : static_cast<uint32_t>(i), medium = state.medium[k];
    if (medium == MediaTable::kVacuum) continue;
    const Ray ray = ray_of(&rays[i / kBlockLanes].ray, i % kBlockLanes);
    const bool hits = rays[i / kBlockLanes].shape[i % kBlockLanes] != kNoHit;
    const float end = hits ? ray.tmax : std::min(far_[k], media_.end_of_space(ray));
    const kinome::Rgb throughput = state.throughput.at(k);
    state.legs->push_back({k, medium, ray.o, ray.d, end, throughput});
    const kinome::Rgb depth = media_.extinction().at(medium) * end;
    kinome::Rgb transmittance(std::exp(-depth.x));
    if (media_.is_coloured())
      transmittance.y = std::exp(-depth.y), transmittance.z = std::exp(-depth.z);
    state.throughput.set(k, throughput * transmittance);
  }
}

/// The same as set_collisions() for media that aren't uniform.
void Segments::track(RayHit16* rays, size_t count, const uint32_t* path, const PathState& state,
                     const RandomSeeds& seeds) {
  for (size_t i = 0; i < count; ++i) {
    const uint32_t k = path ? path[i] : static_cast<uint32_t>(i), medium = state.medium[k];
    if (!media_.grid(medium)) continue;
    const Ray ray = ray_of(&rays[i / kBlockLanes].ray, i % kBlockLanes);
    const bool hits = rays[i / kBlockLanes].shape[i % kBlockLanes] != kNoHit;
    const float end = hits ? ray.tmax : std::min(far_[k], media_.end_of_space(ray));
    position_[k] = static_cast<uint32_t>(i);
    tracking_.add(medium, ray.o, ray.d, end, seeds.of(state.owner[k]), k);
  }
  if (tracking_.is_empty()) return;
  const auto first = static_cast<uint32_t>(scene_.scene().shapes().size());
  for (const auto& [k, distance] :
       tracking_.find_collisions(state.throughput, state.optical_depth)) {
    RayHit16& block = rays[position_[k] / kBlockLanes];
    const size_t lane = position_[k] % kBlockLanes;
    block.ray.tmax[lane] = distance;
    block.shape[lane] = first + state.medium[k] - 1;
  }
  if (state.channel) redraw_channels(count, path, state, seeds);
}

/// Draws the channels of paths in media that aren't uniform again, because their throughput has
/// changed independently of the channel.
void Segments::redraw_channels(size_t count, const uint32_t* path, const PathState& state,
                               const RandomSeeds& seeds) const {
  for (size_t i = 0; i < count; ++i) {
    const uint32_t k = path ? path[i] : static_cast<uint32_t>(i);
    if (!media_.grid(state.medium[k])) continue;
    const uint64_t bits = hash_words(seeds.of(state.owner[k]), 1);
    const float u = kinome::to_unit_float(static_cast<uint32_t>(bits >> 32));
    state.channel[k] = static_cast<uint32_t>(draw_channel(state.throughput.at(k), u));
  }
}

/// Makes continuations `next` of the rays that end at boundaries, in the medium of the other side.
/// Returns their number.
size_t Segments::pass(const RayHit16* rays, size_t count, const uint32_t* path, int next,
                      const PathState& state) {
  met_.find(rays, count, passed_row_of_.data());
  const SurfaceBlock& points = met_.points();
  size_t n = 0;
  for (const Surfaces::Range& range : met_.ranges()) {
    const uint32_t shape = rays[points.ray[range.first] / 16].shape[points.ray[range.first] % 16];
    for (size_t i = range.first; i < range.first + range.count; ++i) {
      const uint32_t k = path ? path[points.ray[i]] : points.ray[i];
      if (range.row->emitter && state.scatterings[k] > 0) continue;
      Ray ray = ray_of(&rays[points.ray[i] / 16].ray, points.ray[i] % 16);
      far_[k] -= continue_behind(points, i, ray);
      state.medium[k] = media_.behind(shape, points.n.at(i), ray.d, state.medium[k]);
      set_ray(beyond_[next][n / kBlockLanes].ray, n % kBlockLanes, ray);
      path_[next][n++] = k;
    }
  }
  for (size_t i = n; n > 0 && i < padded(n); ++i) path_[next][i] = path_[next][n - 1];
  return n;
}

}  // namespace kinome::transport
