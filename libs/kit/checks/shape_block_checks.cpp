// Checks that the block functions of shapes agree with those for single rays and points.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kit/scenes/block_memory.h"
#include "kit/scenes/shape_scene.h"

namespace kinome::check {
namespace {

bool is_near(const Vec3& a, const Vec3& b, const ShapeScene& scene) {
  return max_component(glm::abs(a - b)) <= 1e-4f * (scene.radius + glm::length(scene.centre));
}

constexpr size_t kPacketRays = 16;

/// Sets a packet to random lines, traces each as a single ray, and returns these hits.
std::vector<RayHit> trace_singles(const ShapeScene& at_shape, Random& random, RayHit16& rays) {
  reset(rays.ray);
  std::vector<RayHit> singles;
  for (size_t i = 0; i < kPacketRays; ++i) {
    const Ray line = at_shape.line(random);
    rays.ray.ox[i] = line.o.x, rays.ray.oy[i] = line.o.y, rays.ray.oz[i] = line.o.z;
    rays.ray.dx[i] = line.d.x, rays.ray.dy[i] = line.d.y, rays.ray.dz[i] = line.d.z;
    rays.ray.tmin[i] = 0, rays.ray.tmax[i] = kInfinity;
    rays.shape[i] = rays.primitive[i] = rays.instance[i] = kNoHit;
    singles.push_back(trace(*at_shape.scene, line.o, line.d));
  }
  return singles;
}

/// Returns the number of points of interaction_block() that differ from those of interaction().
int different_points(const ShapeScene& at_shape, const Shape& shape, const RayHit16& rays,
                     const SurfaceBlock& points) {
  shape.interaction_block(&rays, points);
  int different = 0;
  for (size_t k = 0; k < points.count; ++k) {
    const RayHit hit = ray_hit_of(&rays, points.ray[k]);
    const SurfaceInteraction a = shape.interaction(hit.ray, hit.hit);
    different += !(is_near(a.p, points.p.at(k), at_shape) &&
                   glm::length(a.n - points.n.at(k)) < 1e-3f &&
                   glm::length(a.frame.n - points.sn.at(k)) < 1e-3f &&
                   glm::length(a.wi - points.wi.at(k)) < 2e-3f &&
                   std::abs(a.uv.x - points.uv.at(k).x) < 1e-2f);
  }
  return different;
}

}  // namespace

/// Compares packets of 16 rays with single rays, and interaction_block() with interaction().
Outcome shape_blocks(const Subject& subject) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  Random random(subject.request().seed + 8);
  BlockMemory memory(kPacketRays);
  std::vector<const Shape*> shapes(kPacketRays, nullptr);
  const SurfaceBlock block = memory.surface(kPacketRays, shapes.data());
  int tried = 0, other_hits = 0, other_points = 0;
  for (int round = 0; round < subject.samples(200); ++round) {
    RayHit16 rays{};
    const std::vector<RayHit> singles = trace_singles(at_shape, random, rays);
    RenderCounters counters;
    at_shape.scene->intersect(&rays, 1, Coherence::kIncoherent, counters);
    // A block of points must belong to one shape.
    const Shape* shape = nullptr;
    size_t count = 0;
    for (uint32_t i = 0; i < kPacketRays; ++i) {
      const RayHit hit = ray_hit_of(&rays, i);
      ++tried;
      const bool is_same = hit.hit.valid() == singles[i].hit.valid() &&
                           (!hit.hit.valid() ||
                            std::abs(hit.ray.tmax - singles[i].ray.tmax) <= 1e-4f * hit.ray.tmax);
      other_hits += !is_same;
      if (!hit.hit.valid() || !is_same) continue;
      const Shape* const found = at_shape.shapes()[hit.hit.shape].get();
      if (!shape) shape = found;
      if (found == shape) block.ray[count++] = i;
    }
    if (count == 0) continue;
    // The rest of the column must contain valid indices.
    std::fill(block.ray + count, block.ray + kPacketRays, block.ray[0]);
    SurfaceBlock points = block;
    points.count = count;
    other_points += different_points(at_shape, *shape, rays, points);
  }
  outcome.fail_if_many(other_hits, tried, 200,
                       "intersect_block() differs from intersect() for {} of {} rays");
  outcome.fail_if_many(other_points, tried, 100,
                       "interaction_block() differs from interaction() at {} of {} points");
  if (memory.is_overrun()) outcome.fail("a block function writes beyond its columns");
  outcome.measured = fmt::format("{} rays in blocks of 16 compared with single rays", tried);
  return outcome;
}

/// Compares sample_solid_angle_block() with sample_solid_angle().
Outcome shape_sample_blocks(const Subject& subject) {
  Outcome outcome;
  const ShapeScene at_shape(subject);
  const Shape& shape = *at_shape.shapes()[0];
  Random random(subject.request().seed + 9);
  const auto count = static_cast<size_t>(subject.samples(1001));
  BlockMemory memory(count);
  const Columns2 u = memory.two();
  const Columns3 from = memory.three();
  for (size_t i = 0; i < count; ++i) {
    u.set(i, random.unit2());
    from.set(i, at_shape.centre + 2 * at_shape.radius * random.direction());
  }
  const SurfaceSampleBlock samples{memory.three(), memory.three(), memory.two(), memory.one()};
  shape.sample_solid_angle_block(from, u, count, samples);
  int different = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto a = shape.sample_solid_angle(from.at(i), u.at(i));
    const bool has = a && a->pdf > 0;
    different += has != (samples.pdf[i] > 0) ||
                 (has && !(is_near(a->si.p, samples.p.at(i), at_shape) &&
                           std::abs(samples.pdf[i] - a->pdf) <= 1e-2f * a->pdf));
  }
  outcome.fail_if_many(
      different, static_cast<int>(count), 100,
      "sample_solid_angle_block() differs from sample_solid_angle() at {} of {} points");
  if (memory.is_overrun()) outcome.fail("a block function writes beyond its columns");
  outcome.measured = fmt::format("{} samples in a block compared with single samples", count);
  return outcome;
}

}  // namespace kinome::check
