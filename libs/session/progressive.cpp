#include "session/progressive.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>

#include "kinome/film_noise.h"
#include "kinome/log.h"
#include "kinome/process_group.h"
#include "kinome/scheduler.h"

namespace kinome {
namespace {

/// Number of squared differences between lanes that a good error estimate needs. Their number is
/// pixels * (lanes - 1), so small films need more lanes.
constexpr double kMinSquares = 4096;
constexpr double kMinLanes = 4, kMaxLanes = 16;
/// Log a message if the estimated error is below the target by more than this factor.
constexpr double kBetterFactor = 1.5;
/// Safety factor of the total number of samples that is predicted to reach the target error.
/// Without it, a round would often miss the target narrowly.
constexpr double kErrorMargin = 1.1;
/// Limits on the samples of a round, relative to all samples before it. The second round may be
/// large: larger passes are faster per sample and better stratified than the single samples of the
/// first round. Later rounds at most double the number of samples.
constexpr double kMinGrowth = 0.25;
constexpr double kSecondGrowth = 4, kLaterGrowth = 1;

/// Fraction of the remaining time for the first round. It is low, because the time per sample is
/// only a forecast.
constexpr double kFirstFraction = 0.4;
/// Fraction of the remaining time for later rounds. Their time per sample is known from the
/// previous round.
constexpr double kFraction = 0.93;
/// Fraction for a round that is more than kUncertainGrowth times as large as the previous one. Its
/// time is predicted less reliably.
constexpr double kUncertainFraction = 0.7;
constexpr double kUncertainGrowth = 4;
/// Maximum size of a round relative to the previous one.
constexpr double kMaxGrowth = 16;
/// No further round begins if less than this fraction of the whole time is left.
constexpr double kEndFraction = 0.01;

class Progressive {
 public:
  Progressive(Passes& passes, Film& film, RenderJob& job, const PassCallback& on_pass)
      : passes_(passes), film_(film), job_(job), budget_(job.budget()), on_pass_(on_pass) {}

  void run() {
    const bool has_time = budget_.seconds > 0, has_error = budget_.rel_mse > 0;
    const double min_samples = film_.lanes();
    double next = has_time    ? agree(job_.group(), first_in_time())
                  : has_error ? min_samples
                              : passes_.samples();
    if (has_error) next = std::min(next, min_samples);
    next = std::max(min_samples, next);
    while (true) {
      round(next);
      if (job_.cancelled()) break;
      if (!has_time && !has_error) break;
      next = job_.decide([&] {
        const double in_time = has_time ? next_in_time() : kInfinity;
        return has_error ? std::min(in_time, next_by_error()) : in_time;
      });
      if (next < 1) break;
    }
    job_.set_deadline(kInfinity);
    job_.stats().samples = done_;
    const auto error = estimate_rel_mse(film_, samples_);
    if (!error) return;
    job_.stats().rel_mse = *error;
    if (*error < budget_.rel_mse / kBetterFactor) log_why_better(*error);
  }

 private:
  double now() const { return job_.seconds(); }

  void log_why_better(double error) const {
    std::ostringstream text;
    text.precision(3);
    text << "the relMSE is " << error << " with " << done_ << " samples per pixel, better than "
         << budget_.rel_mse << " as requested, because "
         << (rounds_ == 1 ? "an estimate needs that many samples"
                          : "the last passes converged faster than predicted");
    log_info(text.str());
  }

  /// Renders `samples` samples per pixel in total, one pass per lane. If there are fewer samples
  /// than lanes, the lanes with the fewest samples come first.
  void round(double samples) {
    const double start = now(), before = done_, target = before + samples;
    showing_seconds_ = 0;
    const auto [begin, end] = progress_of(start, samples);
    std::vector<uint32_t> order(film_.lanes());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [this](uint32_t a, uint32_t b) { return samples_[a] < samples_[b]; });
    for (const uint32_t lane : order) {
      const bool is_first = done_ == before;
      // Stop within half a sample of the target.
      if (!is_first && (job_.cancelled() || done_ > target - 0.5)) break;
      const double own = target / film_.lanes() - samples_[lane];
      film_.set_lane(lane);
      const double done = (done_ - before) / samples;
      const double after = std::min(1., done + std::max(1., own) / samples);
      job_.begin_pass(++pass_, begin + (end - begin) * done, begin + (end - begin) * after);
      const double rendered = passes_.render(std::max(1., own));
      samples_[lane] += rendered;
      done_ += rendered;
      show();
    }
    job_.begin_pass(0, 0, 1);
    ++rounds_;
    last_ = done_ - before;
    last_seconds_ = now() - start - showing_seconds_;
  }

  /// Calls on_pass_. The time of the call is part of the budget. It is excluded from the measured
  /// time per sample.
  void show() {
    if (!on_pass_ || job_.cancelled()) return;
    const double start = now();
    job_.stats().samples = done_;
    on_pass_(develop(film_, budget_, job_.stats()), job_.stats());
    showing_seconds_ += now() - start;
  }

  /// Returns the progress, from 0 to 1, before and after a round of `more` samples of all lanes.
  /// For a target error, the predicted total of samples changes from round to round. So that
  /// progress never decreases, a round advances it by a fraction of what remains: the round's
  /// samples divided by all samples that are predicted to be missing.
  std::pair<double, double> progress_of(double time, double more) {
    if (budget_.seconds > 0) {
      const double sample = last_ > 0 ? last_seconds_ / last_ : passes_.seconds_per_sample();
      const double begin = std::max(progress_, std::min(1., time / budget_.seconds));
      progress_ = std::max(begin, std::min(1., (time + more * sample) / budget_.seconds));
      return {begin, progress_};
    }
    const bool is_guess = budget_.rel_mse > 0 && rounds_ == 0;
    const double left = is_guess ? (1 + kSecondGrowth) * more : std::max(predicted_ - done_, more);
    const double begin = progress_;
    progress_ += (1 - progress_) * more / left;
    return {begin, progress_};
  }

  double first_in_time() const {
    const double sample = passes_.seconds_per_sample();
    return sample > 0 ? kFirstFraction * (budget_.seconds - now()) / sample : 0;
  }

  double next_in_time() {
    if (!deadline_) {
      // The first round is over, so all pixels have samples. Later rounds may end at a deadline.
      const double start = now();
      const Image image = develop(film_, budget_, job_.stats());
      const double after = budget_.seconds_after ? budget_.seconds_after(image) : 0;
      deadline_ = budget_.seconds - after - (now() - start);
      job_.set_deadline(*deadline_);
    }
    const double left = *deadline_ - now() - showing_seconds_;
    if (left < kEndFraction * budget_.seconds) return 0;
    const double fits = left * last_ / std::max(last_seconds_, 1e-9);
    const double next = fits * (fits > kUncertainGrowth * last_ ? kUncertainFraction : kFraction);
    // A round has at least one sample per lane; stop if that doesn't fit.
    const double min_samples = film_.lanes();
    return std::min(fits < min_samples ? 0. : std::max(next, min_samples), kMaxGrowth * last_);
  }

  double next_by_error() {
    const double limit = std::max(RenderBudget::kMaxSamples, passes_.samples());
    const auto error = estimate_rel_mse(film_, samples_);
    if (!error || *error <= budget_.rel_mse || done_ >= 0.999 * limit) return 0;
    const double missing = kErrorMargin * *error / budget_.rel_mse - 1;
    const double more = std::min(
        done_ * std::clamp(missing, kMinGrowth, rounds_ == 1 ? kSecondGrowth : kLaterGrowth),
        limit - done_);
    predicted_ = std::min(done_ * (1 + std::max(missing, kMinGrowth)), limit);
    return std::max(1., more);
  }

  Passes& passes_;
  Film& film_;
  RenderJob& job_;
  const RenderBudget& budget_;
  const PassCallback& on_pass_;
  uint64_t pass_ = 0;
  int rounds_ = 0;
  std::vector<double> samples_ = std::vector<double>(film_.lanes());  ///< samples of each lane
  double done_ = 0;                                                   ///< samples of all lanes
  double predicted_ = 0;  ///< predicted samples of all lanes at the end
  double progress_ = 0;   ///< progress at the end of the current round, 0 to 1
  double last_ = 0;       ///< samples of all lanes in the last round
  double last_seconds_ = 0;
  double showing_seconds_ = 0;  ///< time of the callbacks in the last round
  std::optional<double> deadline_;
};

}  // namespace

uint32_t lanes_for(const RenderBudget& budget, const Film& film) {
  if (budget.lanes > 0) return budget.lanes;
  if (!(budget.rel_mse > 0)) return 1;
  const double pixels = std::max(1, film.crop().area());
  return static_cast<uint32_t>(
      std::clamp(1 + std::ceil(kMinSquares / pixels), kMinLanes, kMaxLanes));
}

std::optional<double> estimate_rel_mse(const Film& film, std::span<const double> samples) {
  const uint32_t lanes = film.lanes();
  if (lanes < kMinLanes) return std::nullopt;
  const double all_samples = std::accumulate(samples.begin(), samples.end(), 0.);
  const auto pixels = static_cast<size_t>(film.crop().area());
  std::vector<glm::dvec3> colors(lanes);
  const auto read = [&](size_t pixel) {
    glm::dvec3 sum(0.);
    for (uint32_t l = 0; l < lanes; ++l) {
      const std::optional<Rgb> color = film.lane_color(pixel, l);
      colors[l] = color ? glm::dvec3(*color) : glm::dvec3(std::nan(""));
      sum += samples[l] * colors[l];
    }
    return sum;
  };
  double mean = 0;
  for (size_t p = 0; p < pixels; ++p) mean += glm::dot(read(p), glm::dvec3(1 / 3.)) / all_samples;
  mean /= static_cast<double>(pixels);
  const double floor = mean != 0 ? 0.01 * mean * mean : 1;  // absolute errors for a black image
  double total = 0;
  for (size_t p = 0; p < pixels; ++p) {
    const glm::dvec3 sum = read(p);
    const glm::dvec3 all = sum / all_samples;
    for (uint32_t a = 0; a < lanes; ++a) {
      for (uint32_t b = a + 1; b < lanes; ++b) {
        const glm::dvec3 difference = colors[a] - colors[b];
        const glm::dvec3 others = (sum - samples[a] * colors[a] - samples[b] * colors[b]) /
                                  (all_samples - samples[a] - samples[b]);
        const glm::dvec3 size = 0.5 * (others * others + all * all);
        // Estimates the relative variance of one sample. Assumes that a lane's variance is
        // inversely proportional to its number of samples.
        total += glm::dot(difference * difference / (size + floor), glm::dvec3(1 / 3.)) /
                 (1 / samples[a] + 1 / samples[b]);
      }
    }
  }
  if (!std::isfinite(total)) return std::nullopt;
  const double pairs = 0.5 * lanes * (lanes - 1.);
  return total / (static_cast<double>(pixels) * pairs * all_samples);
}

namespace {

Image develop_by_threads(const Film& film, const Scheduler& scheduler) {
  constexpr int kPixelsOfPart = 1 << 14, kMaxParts = 64;
  const Rect& crop = film.crop();
  const int height = crop.height();
  const int count = std::clamp(crop.area() / kPixelsOfPart, 1, std::min(height, kMaxParts));
  if (count == 1) return film.develop();
  std::vector<Image> parts(static_cast<size_t>(count));
  scheduler.parallel_for(parts.size(), [&](size_t part) {
    const auto row_of = [&](size_t index) {
      return crop.y0 + static_cast<int>(index * static_cast<size_t>(height) / parts.size());
    };
    parts[part] = film.develop({crop.x0, row_of(part), crop.x1, row_of(part + 1)});
  });
  Image image{crop.width(), height, parts[0].channels, {}};
  image.data.reserve(static_cast<size_t>(crop.area()) * image.channels.size());
  for (Image& part : parts) {
    image.data.insert(image.data.end(), part.data.begin(), part.data.end());
    part = {};
  }
  return image;
}

}  // namespace

Image develop(const Film& film, const RenderBudget& budget, RenderStats& stats,
              const Scheduler* scheduler) {
  Image image = scheduler ? develop_by_threads(film, *scheduler) : film.develop();
  if (budget.lanes == 0) return image;
  const FilmNoise noise = film_noise(film);
  stats.renders = noise.renders;
  stats.variance_of_mean = noise.variance_of_mean;
  return with_channels_of(image, noise.image);
}

void render_passes(Passes& passes, Film& film, RenderJob& job, const PassCallback& on_pass) {
  Progressive(passes, film, job, on_pass).run();
}

}  // namespace kinome
