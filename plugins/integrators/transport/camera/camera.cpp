#include "transport/camera/camera.h"

#include <algorithm>

#include "kinome/film.h"
#include "kinome/wide/surface_point.h"
#include "transport/shadows/rays.h"
#include "transport/surfaces/light_columns.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Sets one coordinate of the samples' film positions, like film_position(). `first`: the pixels'
/// coordinates.
void place_in_pixels(const PixelSamples& samples, const uint32_t* first, const float* offset,
                     float* position) {
  for (size_t p = 0, i = 0; p < samples.pixels; ++p, i += samples.samples) {
    // Negative for pixels left of a film that samples its border.
    const PixelRange pixel(static_cast<int32_t>(first[p]));
    // Values that reach into the next pixel are overwritten there.
    for (size_t s = 0; s < samples.samples; s += kLanes) {
      pixel.at(Float::load(offset + i + s)).store(position + i + s);
    }
  }
}

}  // namespace

Camera::Camera(const SceneTable& scene, const Sensor& sensor, size_t rays, bool hide_emitters)
    : scene_(scene),
      sensor_(sensor),
      hide_emitters_(hide_emitters),
      passes_(hide_emitters && scene.scene().has_surface_emitters()),
      arena_(rays + kBlockLanes),
      u_(arena_.two()),
      aperture_(arena_.two()),
      position_(arena_.two()),
      rays_(arena_.ray_hits()),
      beyond_(passes_ ? arena_.ray_hits() : nullptr),
      passing_(arena_.indices()),
      far_(arena_.floats()),
      toward_(arena_.three()),
      surfaces_(scene, rays),
      per_point_(Surfaces::max_points(scene, rays) + rays + kBlockLanes),
      light_(per_point_.three()) {}

void Camera::place(const PixelSamples& samples) {
  const size_t count = samples.count();
  const Sampler& sampler = sensor_.sampler();
  sampler.fill_2d_block(samples, 0, u_);
  place_in_pixels(samples, samples.x, u_.x, position_.x);
  place_in_pixels(samples, samples.y, u_.y, position_.y);
  if (sensor_.needs_aperture_sample()) {
    sampler.fill_2d_block(samples, 2, aperture_);
  } else {
    std::fill_n(aperture_.x, padded(count), 0.5f);
    std::fill_n(aperture_.y, padded(count), 0.5f);
  }
}

void Camera::trace_rays(const PixelSamples& samples, RenderCounters& counters) {
  place(samples);
  trace_rays(position_, aperture_, samples.count(), counters);
}

void Camera::make_rays(const PixelSamples& samples) {
  place(samples);
  make_rays(position_, aperture_, samples.count());
}

void Camera::make_rays(const Columns2& film_position, const Columns2& aperture, size_t count) {
  count_ = count;
  sensor_.sample_ray_block(film_position, aperture, count, rays_);
  disable_padding(rays_, count);
  clear_hits(rays_, count);
}

void Camera::trace_rays(const Columns2& film_position, const Columns2& aperture, size_t count,
                        RenderCounters& counters) {
  make_rays(film_position, aperture, count);
  if (passes_) {
    for (size_t i = 0; i < count; ++i) far_[i] = rays_[i / 16].ray.tmax[i % 16];
  }
  scene_.scene().intersect(rays_, padded(count) / kBlockLanes, Coherence::kCoherent, counters);
  counters[RayKind::kCamera] += count;
}

void Camera::trace(const PixelSamples& samples, RenderCounters& counters) {
  place(samples);
  trace(position_, aperture_, samples.count(), counters);
}

void Camera::trace(const Columns2& film_position, const Columns2& aperture, size_t count,
                   RenderCounters& counters) {
  trace_rays(film_position, aperture, count, counters);
  if (passes_) pass_emitters(counters);
  surfaces_.find(rays_, count, Surfaces::Which::kAll);
}

/// Continues rays that ended on a surface that emits behind this surface, until none ends there.
void Camera::pass_emitters(RenderCounters& counters) {
  for (;;) {
    surfaces_.find(rays_, count_, Surfaces::Which::kEmitting);
    size_t n = 0;
    for (const Surfaces::Range& range : surfaces_.ranges()) {
      for (size_t i = range.first; i < range.first + range.count; ++i) {
        const SurfaceBlock& points = surfaces_.points();
        const uint32_t k = points.ray[i];
        Ray ray = ray_of(&rays_[k / 16].ray, k % 16);
        ray.o = origin_off_surface(points.p.at(i), points.n.at(i), points.p_error[i], ray.d);
        ray.tmin = 0;
        ray.tmax = far_[k] -= ray.tmax;
        set_ray(beyond_[n / 16].ray, n % 16, ray);
        passing_[n++] = k;
      }
    }
    if (n == 0) return;
    disable_padding(beyond_, n);
    clear_hits(beyond_, n);
    scene_.scene().intersect(beyond_, padded(n) / kBlockLanes, Coherence::kCoherent, counters);
    counters[RayKind::kCamera] += n;
    for (size_t i = 0; i < n; ++i) copy_ray_hit(beyond_, i, rays_, passing_[i]);
  }
}

void Camera::find_alpha(float* alpha) const {
  for (size_t i = 0; i < count_; ++i) alpha[i] = hit(i) ? 1.f : 0.f;
}

void Camera::set_seen_light(const Columns3& radiance) {
  clear_radiance(scene_, radiance, count_);
  if (hide_emitters_) return;
  const Emitter* const environment = scene_.scene().environment();
  if (scene_.scene().has_surface_emitters()) {
    const SurfaceBlock& points = surfaces_.points();
    for (const Surfaces::Range& range : surfaces_.ranges()) {
      if (!range.row->emitter) continue;
      const size_t first = range.first;
      range.row->emitter->eval_surface_block(points.part(first, range.count), {},
                                             light_.from(first), nullptr);
      const Columns3 to = radiance.from(range.row->group_offset);
      for (size_t i = first; i < first + range.count; ++i) to.set(points.ray[i], light_.at(i));
    }
  }
  const auto missed = surfaces_.missed();
  if (!environment || missed.empty()) return;
  for_lanes(missed.size(),
            [&](size_t i) { GatheredRays(rays_, missed.data() + i).d().store(toward_, i); });
  environment->eval_environment_block(toward_, missed.size(), light_, nullptr);
  const Columns3 to = radiance.from(scene_.environment_offset());
  for (size_t i = 0; i < missed.size(); ++i) to.set(missed[i], light_.at(i));
}

}  // namespace kinome::transport
