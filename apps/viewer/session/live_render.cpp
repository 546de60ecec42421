#include "session/live_render.h"

#include <algorithm>

#include "kinome/render.h"

namespace kinome::viewer {
namespace {

/// Minimum number of film lanes from which an error can be estimated.
constexpr uint32_t kLanes = 4;
/// Rendering time [s] from which the film is saved before each pass, so that an interrupted pass
/// doesn't lose it. Before that, starting again is just as fast.
constexpr double kMinSecondsToKeep = 0.5;
/// Maximum time of a pass [s]. Pausing takes effect between passes.
constexpr double kMaxPassSeconds = 1;
/// Maximum time for estimates of the error as a fraction of the rendering time. An estimate uses
/// only one thread, so that the others wait for it.
constexpr double kMaxEstimateShare = 0.02;

/// Resets the context, which may hold the state of a render that an exception has ended.
void begin(RenderContext& context) {
  context.job.stats() = {};
  context.job.stats().threads = context.scheduler.threads();
  context.job.set_deadline(kInfinity);
  context.job.begin_pass(0, 0, 1);
}

}  // namespace

std::optional<Image> render_once(const Scene& scene, const Sensor& sensor, RenderContext& context) {
  const Integrator& integrator = scene.integrator();
  Film& film = sensor.film();
  begin(context);
  film.prepare(integrator.layers(), integrator.channels());
  {
    const StageTimer timer(context.job.stats().render_seconds);
    integrator.render(scene, sensor, context);
  }
  if (context.job.interrupted()) return std::nullopt;
  context.job.stats().samples = sensor.sampler().sample_count();
  context.job.stats().non_finite_samples += film.non_finite();
  return film.develop();
}

LiveRender::LiveRender(const Scene& scene, const Sensor& sensor, RenderContext& context)
    : context_(context), film_(sensor.film()), lane_samples_(kLanes) {
  const double start = context.job.seconds();
  const Integrator& integrator = scene.integrator();
  begin(context);
  film_.prepare(integrator.layers(), integrator.channels(), kLanes);
  passes_ = integrator.begin(scene, sensor, context, kInfinity);
  seconds_ = context.job.seconds() - start;
}

bool LiveRender::pass() {
  const double start = context_.job.seconds();
  const auto smallest = std::min_element(lane_samples_.begin(), lane_samples_.end());
  // In the first round each lane gets a single sample, so that an image appears soon.
  double samples = pass_ < kLanes ? 1 : std::max(1., done_ / kLanes);
  if (last_seconds_ > 0) {
    samples = std::min(samples, std::max(1., kMaxPassSeconds * last_samples_ / last_seconds_));
  }
  film_.set_lane(static_cast<uint32_t>(smallest - lane_samples_.begin()));
  // Uses the pass indices 1, 2, ..., so that the samples differ from those of render_once().
  context_.job.begin_pass(++pass_, 0, 1);
  // The film can only be restored once each lane has light paths.
  const bool is_kept = seconds_ > kMinSecondsToKeep && pass_ > kLanes;
  if (is_kept) keep_film();
  const double rendered = passes_->render(samples);
  if (context_.job.interrupted()) {
    is_whole_ = is_kept && put_film_back();
    return false;
  }
  *smallest += rendered;
  done_ += rendered;
  last_samples_ = rendered;
  last_seconds_ = context_.job.seconds() - start;
  seconds_ += last_seconds_;
  context_.job.stats().samples = done_;
  context_.job.stats().render_seconds = seconds_;
  context_.job.stats().non_finite_samples = film_.non_finite();
  return true;
}

void LiveRender::keep_film() {
  kept_.clear();
  film_.transfer([this](void* bytes, size_t count) {
    const char* const begin = static_cast<const char*>(bytes);
    kept_.insert(kept_.end(), begin, begin + count);
  });
}

bool LiveRender::put_film_back() {
  size_t at = 0;
  return film_.transfer([&](void* bytes, size_t count) {
    std::copy_n(kept_.data() + at, count, static_cast<char*>(bytes));
    at += count;
  });
}

Image LiveRender::develop() const {
  return film_.develop();
}

double LiveRender::rel_mse() {
  if (sample_error_ < 0 ||
      estimate_seconds_ <= kMaxEstimateShare * (seconds_ - estimated_seconds_)) {
    const double start = context_.job.seconds();
    const auto estimate = estimate_rel_mse(film_, lane_samples_);
    estimate_seconds_ = context_.job.seconds() - start;
    estimated_seconds_ = seconds_;
    sample_error_ = estimate ? *estimate * done_ : -1;
  }
  return sample_error_ < 0 ? -1 : sample_error_ / done_;
}

}  // namespace kinome::viewer
