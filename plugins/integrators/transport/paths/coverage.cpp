#include "transport/paths/coverage.h"

#include <algorithm>

#include "kinome/wide/surface_point.h"
#include "transport/paths/paths.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

Coverage::Coverage(const SceneTable& scene, const Sampler& sampler, const PathSettings& settings,
                   size_t rays)
    : scene_(scene),
      sampler_(sampler),
      max_depth_(settings.length.max_depth),
      is_opaque_(scene.scene().environment() && !settings.hide_emitters),
      passes_(std::any_of(scene.rows().begin(), scene.rows().end(),
                          [](const auto& row) { return row.bsdf->has_null_lobe(); })),
      numbers_(rays),
      per_point_(Surfaces::max_points(scene, rays)),
      per_ray_(rays),
      u1_(per_point_.floats()),
      u2_(per_point_.two()),
      answer_(make_answer(per_point_)),
      rays_(per_ray_.ray_hits()),
      met_(scene, rays),
      ray_owner_(per_ray_.indices()),
      owner_(per_point_.indices()) {}

void Coverage::find(const PixelSamples& samples, const Camera& camera, float* alpha,
                    RenderCounters& counters) {
  const float background = is_opaque_ && max_depth_ > 0 ? 1.f : 0.f;
  std::fill_n(alpha, samples.count(), background);
  if (is_opaque_) return;
  const Surfaces* surfaces = &camera.surfaces();
  const uint32_t* owner = surfaces->points().ray;
  for (uint32_t depth = 1;; ++depth) {
    const size_t rays = cover(samples, *surfaces, owner, depth, alpha);
    if (rays == 0) return;
    disable_padding(rays_, rays);
    clear_hits(rays_, rays);
    scene_.scene().intersect(rays_, padded(rays) / kBlockLanes, Coherence::kCoherent, counters);
    counters[RayKind::kCamera] += rays;
    met_.find(rays_, rays, Surfaces::Which::kAll);
    const SurfaceBlock& points = met_.points();
    for (size_t i = 0; i < points.count; ++i) owner_[i] = ray_owner_[points.ray[i]];
    surfaces = &met_;
    owner = owner_;
  }
}

/// Sets alpha to 1 for rays that end at these points, `depth` edges from the camera. Puts rays that
/// go straight on into rays_ and returns their number.
size_t Coverage::cover(const PixelSamples& samples, const Surfaces& surfaces,
                       const uint32_t* owner, uint32_t depth, float* alpha) {
  const SurfaceBlock& points = surfaces.points();
  const bool is_last = depth + 1 > max_depth_;
  size_t rays = 0;
  for (const Surfaces::Range& range : surfaces.ranges()) {
    const size_t first = range.first, end = first + range.count;
    if (is_last && !range.row->emitter) continue;
    if (is_last || !passes_ || !range.row->bsdf->has_null_lobe()) {
      for (size_t i = first; i < end; ++i) alpha[owner[i]] = 1;
      continue;
    }
    const uint32_t dimension = Paths::bsdf_dimension(depth);
    const size_t count = padded(range.count);
    numbers_.fill_1d(sampler_, samples, dimension, owner + first, count, u1_ + first);
    numbers_.fill_2d(sampler_, samples, dimension + 1, owner + first, count, u2_.from(first));
    range.row->bsdf->shade_block(points.part(first, range.count),
                                 {.u1 = u1_ + first, .u2 = u2_.from(first)}, answer_.from(first));
    rays = pass(points, range, owner, rays, alpha);
  }
  return rays;
}

/// Handles points whose materials have been sampled. Sets alpha to 1 for rays that end there, and
/// appends those that go straight on to the first `rays` of rays_. Returns the new number of rays.
size_t Coverage::pass(const SurfaceBlock& points, const Surfaces::Range& range,
                      const uint32_t* owner, size_t rays, float* alpha) {
  for (size_t i = range.first; i < range.first + range.count; ++i) {
    if (!(answer_.is_delta[i] == kNullSample) || !(answer_.sample_pdf[i] > 0)) {
      alpha[owner[i]] = 1;
      continue;
    }
    const Frame frame{points.s.at(i), points.t.at(i), points.sn.at(i)};
    const kinome::Vec3 d = frame.to_world(answer_.wo.at(i));
    const Ray ray(origin_off_surface(points.p.at(i), points.n.at(i), points.p_error[i], d), d);
    set_ray(rays_[rays / kBlockLanes].ray, rays % kBlockLanes, ray);
    ray_owner_[rays++] = owner[i];
  }
  return rays;
}

}  // namespace kinome::transport
