// The part of LocalLight that traces light paths from the sources and leaves points where they hit.
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/patches.h"
#include "clustered/product/tiles/spread.h"
#include "kinome/block_points.h"
#include "kinome/render_context.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/light_paths/adjoint.h"
#include "transport/light_paths/adjoint_samples.h"
#include "transport/shadows/rays.h"

namespace kinome {
namespace {

constexpr uint64_t kSeedOfWalks = 0x77616c6b;
/// Number of light points, or walks, that a thread draws together.
constexpr uint32_t kChunk = 1024;
/// Random numbers of a walk at a surface.
enum WalkNumber : uint32_t { kLobe, kDirection, kSurvival = kDirection + 2 };
/// Maximum survival probability of roulette, so that lossless paths end.
constexpr float kMaxSurvival = 0.95f;

}  // namespace

/// Memory in which one thread draws a chunk of light points.
struct LocalLight::Walker {
  transport::Arena per_draw{kChunk}, per_point;
  Columns2 position, direction;  ///< random numbers of draws of one source
  std::vector<int> aimed;        ///< sphere at which each draw is aimed; see pick_aim()
  SurfaceBlock leaving;          ///< points of an emitting surface
  RayHit16* rays;                ///< current ray of each walk
  float* distance;               ///< distance of each hit along the ray
  transport::Surfaces met;
  float* u1;
  Columns2 u2;
  transport::AdjointSamples next;
  /// Walks before their next edge, and reused memory for the walks of a chunk, which is slow to
  /// allocate.
  std::vector<LightWalk> walks, spare;

  explicit Walker(const transport::SceneTable& table)
      : per_point(transport::Surfaces::max_points(table, kChunk)),
        position(per_draw.two()),
        direction(per_draw.two()),
        aimed(kChunk),
        leaving(per_draw.points()),
        rays(per_draw.ray_hits()),
        distance(per_point.floats()),
        met(table, kChunk),
        u1(per_point.floats()),
        u2(per_point.two()),
        next(per_point.capacity()) {}

  /// Adds a walk with its ray to out.walks.
  void begin(const LightWalk& walk, const Ray& ray, Drawn& out) {
    const size_t k = out.walks.size();
    set_ray(rays[k / kBlockLanes].ray, k % kBlockLanes, ray);
    out.walks.push_back(walk);
  }
};

void LocalLight::draw_part(bool bounce, uint32_t count, uint64_t seed, RenderContext& context,
                           std::vector<Drawn>& chunks) const {
  const uint32_t parts = (count + kChunk - 1) / kChunk;
  const size_t before = chunks.size();
  chunks.resize(before + parts);
  const LightGuide& guide = bounce ? bounce_guide_ : surface_guide_;
  const std::vector<double>& unguided = bounce ? bounce_ends_ : surface_ends_;
  const Turns turns(guide.empty() ? unguided : guide.ends(), count, seed);
  const auto draw_chunk = [&](size_t c, Walker& walker) {
    const auto begin = static_cast<uint32_t>(c) * kChunk;
    const uint32_t end = std::min(begin + kChunk, count);
    Drawn& out = chunks[before + c];
    out.walks.swap(walker.spare);
    std::vector<LightOrigin> origins;
    for (uint32_t i = begin; i < end;) {
      const uint32_t first = i, source = turns[i].source;
      const LightNumbers numbers(hash_words(seed, source));
      origins.clear();
      for (; i < end && turns[i].source == source; ++i) {
        LightOrigin& origin = origins.emplace_back(numbers.origin(source, turns[i].number));
        origin.guided = guide.warp(source, origin.numbers);
      }
      if (bounce) {
        leave(origins, hash_words(seed, kSeedOfWalks), first, walker, out);
      } else {
        add_surface_points(origins, walker, out);
      }
    }
    while (take_parts(walker, out)) walk_on(walker, out);
    out.walks.swap(walker.spare);
  };
  transport::Workers<Walker> walkers;
  context.scheduler.parallel_for(parts, [&](size_t c) {
    walkers.with_one([&] { return std::make_unique<Walker>(table_); },
                     [&](Walker& walker) { draw_chunk(c, walker); });
  });
  for (size_t c = before; c < chunks.size(); ++c)
    context.job.stats().counters.add(chunks[c].counters);
}

/// Draws points of the surface of a source, one for each origin, into walker.leaving.
void LocalLight::sample_source(std::span<const LightOrigin> origins, Walker& walker) const {
  const Shape& shape = *sources_[origins[0].source].emitter->shape();
  for (size_t k = 0; k < origins.size(); ++k) walker.position.set(k, origins[k].position());
  for (size_t k = origins.size(); k < padded(origins.size()); ++k) {
    walker.position.set(k, origins.back().position());
  }
  std::fill_n(walker.leaving.shape, padded(origins.size()), &shape);
  shape.sample_surface_block(walker.position, walker.leaving.part(0, origins.size()));
}

/// Adds a light point on the surface of the source for each origin.
void LocalLight::add_surface_points(std::span<const LightOrigin> origins, Walker& walker,
                                    Drawn& out) const {
  const Source& source = sources_[origins[0].source];
  const float area = source.emitter->shape()->area();
  if (!(area > 0)) return;
  sample_source(origins, walker);
  const float density = static_cast<float>(surface_count_) * source.surface_share / area;
  for (size_t k = 0; k < origins.size(); ++k) {
    SurfaceInteraction si = interaction_of(walker.leaving, k);
    si.wi = Vec3(0, 0, 1);
    LightPoint point;
    point.power = source.emitter->eval_surface(si) / (density * origins[k].guided);
    if (is_black(point.power)) continue;
    point.position = si.p;
    point.normal = si.frame.n;
    point.geometric = si.n;
    point.group = source.group;
    if (surface_partition_.size() > 0) {
      point.cell = surface_cell(si);
      point.eye_ratio = eye_factors_[point.cell] / density;
    }
    out.points.push_back(point);
    out.origins.push_back(origins[k]);
    out.is_deep.push_back(0);
    out.walk_of.push_back(0);
  }
}

/// Starts a walk from the source for each origin. The walk's seed depends on `seed` and on the
/// index of the draw.
void LocalLight::leave(std::span<const LightOrigin> origins, uint64_t seed, uint32_t first_draw,
                       Walker& walker, Drawn& out) const {
  const Source& source = sources_[origins[0].source];
  const Emitter& emitter = *source.emitter;
  const EmissionBlock block{walker.leaving.p, walker.leaving.n, walker.leaving.s};
  if (emitter.is_surface()) {
    if (!(emitter.shape()->area() > 0)) return;
    sample_source(origins, walker);
  } else {
    for (size_t k = 0; k < origins.size(); ++k) {
      Vec2 position = origins[k].position(), direction = origins[k].direction();
      walker.aimed[k] = pick(source, position, direction);
      walker.position.set(k, position);
      walker.direction.set(k, direction);
    }
    emitter.sample_emission_block(walker.position, walker.direction, origins.size(), block);
  }
  for (uint32_t k = 0; k < origins.size(); ++k) {
    LightWalk walk;
    Ray ray;
    float gain = 1;
    if (emitter.is_surface()) {
      walk.x = interaction_of(walker.leaving, k);
      const auto sample =
          leave_surface(emitter, *walk.x, origins[k].direction(), surface_cones(*walk.x));
      if (!sample) continue;
      ray = sample->ray();
      walk.power = sample->power;
      gain = sample->pdf_direction / surface_emission_pdf(*walk.x, sample->d);
    } else {
      EmissionSample sample;
      sample.o = block.o.at(k);
      sample.d = block.d.at(k);
      sample.power = block.power.at(k);
      gain = aim(source, walker.aimed[k], walker.position.at(k), walker.direction.at(k), sample);
      ray = Ray(sample.o, sample.d);
      walk.power = sample.power;
    }
    if (is_black(walk.power)) continue;
    walk.origin = origins[k];
    walk.origin.aimed = gain * source.aimed_part;
    walk.seed = hash_words(seed, first_draw + k);
    walk.d = ray.d;
    walker.begin(walk, ray, out);
  }
}

/// Moves waiting parts of split walks to out.walks. Returns false if there are no walks left.
bool LocalLight::take_parts(Walker& walker, Drawn& out) const {
  while (!out.parts.empty() && out.walks.size() < kChunk) {
    const auto& [walk, ray] = out.parts.back();
    walker.begin(walk, ray, out);
    out.parts.pop_back();
  }
  return !out.walks.empty();
}

/// Traces the next edge of all walks. Replaces them by the walks that continue. Further parts of
/// split walks go to out.parts.
void LocalLight::walk_on(Walker& walker, Drawn& out) const {
  const size_t count = out.walks.size();
  disable_padding(walker.rays, count);
  transport::clear_hits(walker.rays, count);
  scene_.intersect(walker.rays, padded(count) / kBlockLanes, Coherence::kIncoherent, out.counters);
  out.counters[RayKind::kLight] += count;
  const transport::Surfaces& met = walker.met;
  walker.met.find(walker.rays, count, transport::Surfaces::Which::kAll);
  std::swap(walker.walks, out.walks);
  out.walks.clear();
  const std::span<const LightWalk> walks = walker.walks;
  const uint32_t* const ray = met.points().ray;
  for (size_t i = 0; i < met.reflecting(); ++i) {
    const uint32_t k = ray[i];
    walker.distance[i] = walks[k].before + walker.rays[k / kBlockLanes].ray.tmax[k % kBlockLanes];
  }
  // The path will have three more edges: the next one, that to the eye's surface point, and that to
  // the camera.
  const auto may_go_on = [&](const LightWalk& walk) { return walk.edges + 3 <= max_depth(); };
  const bool any_may = std::any_of(walks.begin(), walks.end(), may_go_on);
  const BsdfAnswer* const next = any_may ? &sample_next(walks, walker) : nullptr;
  for (size_t i = 0; i < met.reflecting(); ++i) {
    if (!(met.live()[i] > 0)) continue;
    const LightWalk& walk = walks[ray[i]];
    const SurfaceInteraction si = interaction_of(met.points(), i);
    const size_t before = out.points.size();
    if (i < met.scattering()) land(walk, si, walker.distance[i], out);
    if (!next || !may_go_on(walk)) continue;
    const uint32_t parts = out.points.size() > before ? parts_at(out.points.back()) : 1;
    LightWalk part = walk;
    part.power /= static_cast<float>(parts);
    if (next->sample_pdf[i] > 0) {
      const transport::AdjointSample sample{si.frame.to_world(next->wo.at(i)), next->weight.at(i),
                                            next->is_delta[i] > 0, next->is_delta[i] == kNullSample};
      if (const auto to = go_on(part, si, sample, walker.distance[i])) {
        walker.begin(part, *to, out);
      }
    }
    for (uint32_t k = 1; k < parts; ++k) add_part(walk, si, walker.distance[i], parts, k, out);
  }
}

/// Adds part `index` of a walk that is split into `parts` at a surface point.
void LocalLight::add_part(const LightWalk& walk, const SurfaceInteraction& si, float distance,
                          uint32_t parts, uint32_t index, Drawn& out) const {
  LightWalk part = walk;
  part.power /= static_cast<float>(parts);
  part.seed = hash_words(walk.seed, walk.edges, index);
  const uint64_t seed = hash_words(part.seed, part.edges);
  const auto sample = transport::sample_adjoint(
      si, Lobe::kAll, random_float(seed, kLobe),
      {random_float(seed, kDirection), random_float(seed, kDirection + 1)});
  if (!sample) return;
  if (const auto to = go_on(part, si, *sample, distance)) out.parts.emplace_back(part, *to);
}

/// Samples the next directions of walks at their hits.
const BsdfAnswer& LocalLight::sample_next(std::span<const LightWalk> walks, Walker& walker) const {
  const uint32_t* const ray = walker.met.points().ray;
  for (size_t i = 0; i < walker.met.reflecting(); ++i) {
    const LightWalk& walk = walks[ray[i]];
    const uint64_t seed = hash_words(walk.seed, walk.edges);
    walker.u1[i] = random_float(seed, kLobe);
    walker.u2.set(i, {random_float(seed, kDirection), random_float(seed, kDirection + 1)});
  }
  return walker.next.sample(walker.met, walker.u1, walker.u2);
}

/// Moves a walk to its next edge and returns its ray, or nullopt if the walk ends. The survival
/// probability of roulette is the reflectance, so that all points of a source have about the same
/// power.
std::optional<Ray> LocalLight::go_on(LightWalk& walk, const SurfaceInteraction& si,
                                     const transport::AdjointSample& sample,
                                     float distance) const {
  if (is_black(sample.weight)) return std::nullopt;
  const bool is_lamps = sources_[walk.origin.source].kind == Kind::kLamp;
  if (sample.is_straight && walk.is_direct && !is_lamps && passing()) {
    walk.power = walk.power * sample.weight;
    walk.before = distance;
    ++walk.edges;
    return si.spawn_ray(walk.d);
  }
  const float survival =
      std::min(kMaxSurvival, max_component(walk.power * sample.weight) / max_component(walk.power));
  if (!(random_float(hash_words(walk.seed, walk.edges), kSurvival) < survival)) return std::nullopt;
  const bool is_first = walk.is_direct;
  walk.is_shown = is_first ? sample.is_delta && !is_lamps : walk.is_shown;
  walk.is_hidden = sample.is_delta && (is_first ? is_lamps : walk.is_hidden);
  walk.power = walk.power * sample.weight / survival;
  walk.d = sample.to;
  walk.x.reset();
  walk.is_direct = false;
  walk.before = 0;
  ++walk.edges;
  return si.spawn_ray(walk.d);
}

}  // namespace kinome
