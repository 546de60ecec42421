#include <algorithm>

#include "clustered/product/pass/product_renderer.h"
#include "clustered/product/pilot/pilot.h"
#include "kinome/render_context.h"

namespace kinome {
namespace {

/// Number of light points of a pilot, and the minimum share of the points of a pass. Drawing them
/// takes a large part of a pilot's time.
constexpr float kPilotPoints = 1u << 14, kMinPilotShare = 0.25f;
/// Rays per pixel below which there is no pilot: without and with local light.
constexpr double kMinRaysToLearn = 6, kMinRaysToLearnLocal = 10;
/// Rays per pixel below which the pilot probes one pixel of each square of kSparseSide pixels. It
/// sends one shadow ray for this number of rays per pixel.
constexpr double kMinRaysToProbeAll = 10;
constexpr int kSparseSide = 2;
constexpr double kRaysPerSparseRay = 2;
/// Pilot rays per primary, and for a single primary per pixel. In the second case rays are few, and
/// do more for the image.
constexpr uint32_t kPilotRays = 3, kPilotRaysOfOne = 2;
/// Through a lens with an aperture, pixels see more than one primary shows. The number of primaries
/// is multiplied by this factor, and each has this number of rays.
constexpr uint32_t kLensPrimaries = 2, kLensRays = 1;
/// From this number of primaries per pixel on, forecasts aren't smoothed.
constexpr uint32_t kMinPrimariesUnsmoothed = 4;
/// Maximum share of a render's time for its pilot.
constexpr double kPilotShare = 0.25;

}  // namespace

Pilot::Effort ProductRenderer::effort_of_pilot(double rays_per_pixel) const {
  Pilot::Effort effort;
  if (rays_per_pixel < kMinRaysToProbeAll) {
    effort.primaries = 1;
    effort.rays = static_cast<uint32_t>(std::max(1., rays_per_pixel / kRaysPerSparseRay));
    effort.side = kSparseSide;
    return effort;
  }
  effort.primaries = rays_per_pixel < 24 ? 1 : rays_per_pixel < 60 ? 2 : 4;
  effort.rays = effort.primaries == 1 ? kPilotRaysOfOne : kPilotRays * effort.primaries;
  if (task_.sensor.needs_aperture_sample()) {
    effort.primaries *= kLensPrimaries;
    effort.rays = kLensRays * effort.primaries;
  }
  return effort;
}

LargeArray<PixelForecast> ProductRenderer::send_pilot(Pilot::Effort effort,
                                                      const TileGrid::IsWanted& is_wanted,
                                                      double progress_end) {
  if (cells_.size() > 0) neighbours_ = find_neighbours(cells_, context_.scheduler);
  float share = 1;
  // A trial, which probes some tiles, renders with the points of its pilot.
  if (local_ && !is_wanted) {
    const auto points = static_cast<float>(std::max(local_->points_of_pass(), 1u));
    share = std::clamp(kPilotPoints / points, kMinPilotShare, 1.f);
  }
  const auto& light_rays = context_.job.stats().counters[RayKind::kLight];
  const auto light_rays_before = light_rays;
  const CellLight& light = pilot_light_.emplace(make_light(0, effort.rays_per_pixel(), share));
  light_rays_ = static_cast<double>(light_rays - light_rays_before);
  Pilot pilot(task_, view(), light, neighbours_, effort, is_wanted, addresses_, knowledge_);
  LargeArray<PixelForecast> forecast = pilot.learn(progress_end);
  knowledge_.finish(context_.job.group());
  return forecast;
}

void ProductRenderer::allocate(Pilot::Effort effort, std::span<const PixelForecast> forecast,
                               int width, int height) {
  const StageTimer timer(context_.job.stats().counters.stage_seconds["allocate"]);
  const bool is_noisy = effort.primaries < kMinPrimariesUnsmoothed && task_.settings.smooth_plan;
  allocation_.emplace(forecast, width, height,
                      !task_.settings.adaptive ? RayAllocation::Mode::kEven
                      : is_noisy               ? RayAllocation::Mode::kSmoothed
                                               : RayAllocation::Mode::kAdaptive,
                      context_.scheduler);
}

void ProductRenderer::learn_from_pilot(double rays_per_pixel) {
  if (rays_per_pixel < (local_ ? kMinRaysToLearnLocal : kMinRaysToLearn)) {
    context_.job.skip("pilot", "there are too few rays per pixel to learn from");
    return;
  }
  const double start = context_.job.seconds();
  const Pilot::Effort effort = effort_of_pilot(rays_per_pixel);
  const double rays = effort.rays_per_pixel();
  const auto forecast = send_pilot(effort, nullptr, rays / std::max(rays_per_pixel, 1.));
  pilot_light_.reset();
  if (!context_.job.cancelled()) {
    allocate(effort, forecast, grid_.crop().width(), grid_.crop().height());
    divide_among_methods();
  }
  pilot_rays_ = rays;
  rays_left_ = std::max(0., rays_left_ - rays);
  pilot_seconds_ = context_.job.seconds() - start;
}

bool ProductRenderer::learn_in_time(double seconds, double rays_per_second) {
  context_.job.set_deadline(context_.job.seconds() + kPilotShare * seconds);
  if (!context_.job.cancelled()) {
    learn_from_pilot(seconds * rays_per_second / std::max(1, grid_.crop().area()));
  }
  const bool is_late = context_.job.cancelled();
  if (is_late) {
    // Data that only some tiles have learned can't be used.
    pilot_rays_ = 0;
    allocation_.reset();
    knowledge_.forget();
    context_.job.skip("pilot", "there was too little time");
  }
  context_.job.set_deadline(kInfinity);
  return !is_late;
}

double ProductRenderer::seconds_per_sample() const {
  // If the pilot was cancelled, uses its time and the number of rays of a small pilot.
  const double rays = pilot_rays_ > 0 ? pilot_rays_ : 1 + kPilotRaysOfOne;
  return kRaysPerSample * pilot_seconds_ / rays;
}

}  // namespace kinome
