#include "session/live_render.h"

#include <algorithm>
#include <bit>

#include "kinome/render.h"
#include "kinome/work_source.h"
#include "session/progressive.h"

namespace kinome::viewer {
namespace {

/// Minimum number of film lanes from which an error can be estimated.
constexpr uint32_t kLanes = 4;
/// Maximum time of a pass [s], if it has more than one sample.
constexpr double kMaxPassSeconds = 10;
/// Minimum time between two images of a pass [s], and the maximum fraction of the pass's time in
/// which images are developed. Other threads may wait meanwhile.
constexpr double kMinImageInterval = 1, kMaxImageShare = 0.02;
/// Passes are restricted to a region once the whole image has this number of samples per pixel.
constexpr double kMinSamplesOfRegion = 4;
/// Minimum number of samples per pixel of each pass after the first.
constexpr double kMinSamplesOfPass = 8;
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

/// Restricts a job to the tiles that overlap a region, as long as it exists.
class RegionSource final : public WorkSource {
 public:
  RegionSource(RenderJob& job, const Rect& region) : job_(job), region_(region) {
    job_.set_work_source(this);
  }
  ~RegionSource() override { job_.set_work_source(nullptr); }
  RegionSource(const RegionSource&) = delete;
  RegionSource& operator=(const RegionSource&) = delete;
  bool is_wanted(const Rect& pixels, int /*layer*/) const override {
    return pixels.x0 < region_.x1 && region_.x0 < pixels.x1 && pixels.y0 < region_.y1 &&
           region_.y0 < pixels.y1;
  }

 private:
  RenderJob& job_;
  const Rect region_;
};

/// While this object exists, the commits of a pass call a function with the film's image from time
/// to time.
class ImagesOfPass {
 public:
  ImagesOfPass(RenderContext& context, const LiveRender::ImageCallback& on_image)
      : context_(context), on_image_(on_image), next_(context.job.seconds() + kMinImageInterval) {
    context_.scheduler.set_commit_callback([this](const Film& film, const Rect&) { follow(film); });
  }
  ~ImagesOfPass() { context_.scheduler.set_commit_callback(nullptr); }
  ImagesOfPass(const ImagesOfPass&) = delete;
  ImagesOfPass& operator=(const ImagesOfPass&) = delete;

 private:
  void follow(const Film& film) {
    const double now = context_.job.seconds();
    if (now < next_ || context_.job.interrupted()) return;
    on_image_(film.develop());
    const double seconds = context_.job.seconds() - now;
    next_ = now + std::max(kMinImageInterval, seconds / kMaxImageShare);
  }

  RenderContext& context_;
  const LiveRender::ImageCallback& on_image_;
  double next_;
};

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

LiveRender::LiveRender(const Scene& scene, const Sensor& sensor, RenderContext& context,
                       double max_samples)
    : context_(context),
      film_(sensor.film()),
      max_samples_(max_samples),
      lane_samples_(kLanes) {
  const double start = context.job.seconds();
  const Integrator& integrator = scene.integrator();
  begin(context);
  film_.prepare(integrator.layers(), integrator.channels(), kLanes);
  passes_ = integrator.begin(scene, sensor, context, kInfinity);
  seconds_ = context.job.seconds() - start;
}

/// Returns the number of samples of the next pass: 1, so that an image appears soon, and then
/// powers of two, which samplers stratify best. Passes soon become long, because short ones are
/// slow: with product sampling, one of 16 samples traces three times as many rays per second as one
/// of a single sample.
double LiveRender::samples_of_next_pass() const {
  if (samples() < 1) return 1;
  const double power = std::bit_floor(static_cast<uint64_t>(samples()));
  return std::max(1., std::min(std::max(kMinSamplesOfPass, 2 * power), max_samples_ - samples()));
}

bool LiveRender::pass(const std::optional<Rect>& region, const ImageCallback& on_image) {
  const double start = context_.job.seconds();
  if (!region || !region_ || !is_same(*region, *region_)) in_region_ = 0;
  region_ = region;
  const auto smallest = std::min_element(lane_samples_.begin(), lane_samples_.end());
  double samples = samples_of_next_pass();
  std::optional<RegionSource> source;
  if (region && in_all_ >= kMinSamplesOfRegion) source.emplace(context_.job, *region);
  const double pixels = (source ? *region : film_.crop()).area();
  if (last_work_ > 0) {
    samples =
        std::min(samples, std::max(1., kMaxPassSeconds * last_work_ / (last_seconds_ * pixels)));
  }
  std::optional<ImagesOfPass> images;
  if (on_image && in_all_ > 0) images.emplace(context_, on_image);
  film_.set_lane(static_cast<uint32_t>(smallest - lane_samples_.begin()));
  // Uses the pass indices 1, 2, ..., so that the samples differ from those of render_once().
  context_.job.begin_pass(++pass_, 0, 1);
  const double rendered = passes_->render(samples);
  images.reset();
  if (context_.job.interrupted()) {
    // Once all pixels have samples, the finished tiles of a pass improve the image.
    is_whole_ = in_all_ > 0;
    return false;
  }
  *smallest += rendered;
  (source ? in_region_ : in_all_) += rendered;
  is_even_ = is_even_ && !source;
  last_work_ = rendered * pixels;
  last_seconds_ = context_.job.seconds() - start;
  seconds_ += last_seconds_;
  context_.job.stats().samples = this->samples();
  context_.job.stats().render_seconds = seconds_;
  context_.job.stats().non_finite_samples = film_.non_finite();
  return true;
}

bool LiveRender::survives_interruption(const Picture& picture) {
  return !picture.is_preview && picture.samples > 0;
}

Image LiveRender::develop() const {
  return kinome::develop(film_, {}, context_.job.stats(), &context_.scheduler);
}

double LiveRender::rel_mse() {
  if (!is_even_ || std::ranges::count(lane_samples_, 0.) > 0) return -1;
  if (sample_error_ < 0 ||
      estimate_seconds_ <= kMaxEstimateShare * (seconds_ - estimated_seconds_)) {
    const double start = context_.job.seconds();
    const auto estimate = estimate_rel_mse(film_, lane_samples_);
    estimate_seconds_ = context_.job.seconds() - start;
    estimated_seconds_ = seconds_;
    sample_error_ = estimate ? *estimate * in_all_ : -1;
  }
  return sample_error_ < 0 ? -1 : sample_error_ / in_all_;
}

}  // namespace kinome::viewer
