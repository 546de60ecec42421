#include "render/progressive.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>

#include "kinome/log.h"

namespace kinome {
namespace {

/// Lanes of a small film give as many squares of differences, which is what makes an estimate of
/// their mean.
constexpr double kSquaresWanted = 4096;
constexpr double kLeastLanes = 4, kMostLanes = 16;
/// An estimate that is better than what was asked for by more is worth a word.
constexpr double kPromised = 1.5;
/// A round for what is predicted to be left would often miss it by little.
constexpr double kErrorMargin = 1.1;
constexpr double kLeastGrowth = 0.25;
/// Of what there is. Single samples, as of the first round, take longer and are spread less evenly
/// than those of larger passes: the second round may be large at once, later ones double at most.
constexpr double kSecondGrowth = 4, kLaterGrowth = 1;

/// Of the time left: what the first round takes by its forecast, and others by the speed of the
/// last one, if that was not much smaller.
constexpr double kFirstShare = 0.4;
constexpr double kShare = 0.93;
constexpr double kUnsureShare = 0.7;
constexpr double kUnsureGrowth = 4;
constexpr double kMostGrowth = 16;
/// Of the whole time: too little for another round.
constexpr double kEndShare = 0.01;

class Progressive {
 public:
  Progressive(Passes& passes, Film& film, RenderContext& context, const PassCallback& on_pass)
      : passes_(passes),
        film_(film),
        context_(context),
        budget_(context.budget()),
        on_pass_(on_pass) {}

  void run() {
    const bool has_time = budget_.seconds > 0, has_error = budget_.rel_mse > 0;
    const double least = film_.lanes();
    double next = has_time ? context_.agree(first_in_time()) : has_error ? least : passes_.samples();
    if (has_error) next = std::min(next, least);
    next = std::max(least, next);
    while (true) {
      round(next);
      if (context_.cancelled()) break;
      if (!has_time && !has_error) break;
      next = context_.decide([&] {
        const double in_time = has_time ? next_in_time() : kInfinity;
        return has_error ? std::min(in_time, next_by_error()) : in_time;
      });
      if (next < 1) break;
    }
    context_.set_deadline(kInfinity);
    context_.stats().samples = done_;
    const auto error = estimate_rel_mse(film_, samples_);
    if (!error) return;
    context_.stats().rel_mse = *error;
    if (*error < budget_.rel_mse / kPromised) say_why_better(*error);
  }

 private:
  double now() const { return context_.seconds(); }

  void say_why_better(double error) const {
    std::ostringstream text;
    text.precision(3);
    text << "a relMSE of " << budget_.rel_mse << " is asked for, and the picture has " << error
         << " with " << done_ << " samples a pixel"
         << (rounds_ == 1
                 ? ", the fewest that tell"
                 : ": the last passes, being larger, did better than those before promised");
    log_info(text.str());
  }

  /// So many samples of all lanes together, a pass for each lane; fewer than there are lanes go to
  /// those that have the fewest.
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
      // Half a sample more or less is as good.
      if (!is_first && (context_.cancelled() || done_ > target - 0.5)) break;
      const double own = target / film_.lanes() - samples_[lane];
      film_.set_lane(lane);
      const double at = (done_ - before) / samples;
      const double after = std::min(1., at + std::max(1., own) / samples);
      context_.begin_pass(++pass_, begin + (end - begin) * at, begin + (end - begin) * after);
      const double rendered = passes_.render(std::max(1., own));
      samples_[lane] += rendered;
      done_ += rendered;
      show();
    }
    context_.begin_pass(0, 0, 1);
    ++rounds_;
    last_ = done_ - before;
    last_seconds_ = now() - start - showing_seconds_;
  }

  /// What a callback takes is part of the time, but says nothing of how fast samples are.
  void show() {
    if (!on_pass_ || context_.cancelled()) return;
    const double start = now();
    context_.stats().samples = done_;
    on_pass_(develop(film_, budget_, context_.stats()), context_.stats());
    showing_seconds_ += now() - start;
  }

  /// Shares of all work that are told before and after a round of `more` samples of all lanes. What
  /// an error takes is guessed anew before each: a round is its share of what was left untold, so
  /// that what is told never falls.
  std::pair<double, double> progress_of(double time, double more) {
    if (budget_.seconds > 0) {
      const double sample = last_ > 0 ? last_seconds_ / last_ : passes_.seconds_per_sample();
      const double begin = std::max(told_, std::min(1., time / budget_.seconds));
      told_ = std::max(begin, std::min(1., (time + more * sample) / budget_.seconds));
      return {begin, told_};
    }
    const bool is_guess = budget_.rel_mse > 0 && rounds_ == 0;
    const double left = is_guess ? (1 + kSecondGrowth) * more : std::max(predicted_ - done_, more);
    const double begin = told_;
    told_ += (1 - told_) * more / left;
    return {begin, told_};
  }

  double first_in_time() const {
    const double sample = passes_.seconds_per_sample();
    return sample > 0 ? kFirstShare * (budget_.seconds - now()) / sample : 0;
  }

  double next_in_time() {
    if (!deadline_) {
      // From here on there is a picture.
      const double start = now();
      const Image picture = develop(film_, budget_, context_.stats());
      const double after = budget_.seconds_after ? budget_.seconds_after(picture) : 0;
      deadline_ = budget_.seconds - after - (now() - start);
      context_.set_deadline(*deadline_);
    }
    const double left = *deadline_ - now() - showing_seconds_;
    if (left < kEndShare * budget_.seconds) return 0;
    const double fits = left * last_ / std::max(last_seconds_, 1e-9);
    const double wanted = fits * (fits > kUnsureGrowth * last_ ? kUnsureShare : kShare);
    // Less than one sample of each lane would not be in time.
    const double least = film_.lanes();
    return std::min(fits < least ? 0. : std::max(wanted, least), kMostGrowth * last_);
  }

  double next_by_error() {
    const double limit = std::max(RenderBudget::kMostSamples, passes_.samples());
    const auto error = estimate_rel_mse(film_, samples_);
    if (!error || *error <= budget_.rel_mse || done_ >= 0.999 * limit) return 0;
    const double missing = kErrorMargin * *error / budget_.rel_mse - 1;
    const double more = std::min(
        done_ * std::clamp(missing, kLeastGrowth, rounds_ == 1 ? kSecondGrowth : kLaterGrowth),
        limit - done_);
    predicted_ = std::min(done_ * (1 + std::max(missing, kLeastGrowth)), limit);
    return std::max(1., more);
  }

  Passes& passes_;
  Film& film_;
  RenderContext& context_;
  const RenderBudget& budget_;
  const PassCallback& on_pass_;
  uint64_t pass_ = 0;
  int rounds_ = 0;
  std::vector<double> samples_ = std::vector<double>(film_.lanes());  ///< of each lane
  double done_ = 0;                                                   ///< of all lanes
  double predicted_ = 0;                                              ///< the same at the end
  double told_ = 0;  ///< share of all work at the end of the last round
  double last_ = 0;  ///< samples of all lanes in the last round
  double last_seconds_ = 0;
  double showing_seconds_ = 0;  ///< what callbacks took in the last round
  std::optional<double> deadline_;
};

}  // namespace

uint32_t lanes_for(const RenderBudget& budget, const Film& film) {
  if (budget.lanes > 0) return budget.lanes;
  if (!(budget.rel_mse > 0)) return 1;
  const double pixels = std::max(1, film.crop().area());
  return static_cast<uint32_t>(
      std::clamp(1 + std::ceil(kSquaresWanted / pixels), kLeastLanes, kMostLanes));
}

std::optional<double> estimate_rel_mse(const Film& film, std::span<const double> samples) {
  const uint32_t lanes = film.lanes();
  if (lanes < kLeastLanes) return std::nullopt;
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
  const double floor = mean != 0 ? 0.01 * mean * mean : 1;  // a black picture: absolute errors
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
        // The variance of a sample, if that of a lane falls as its samples rise.
        total += glm::dot(difference * difference / (size + floor), glm::dvec3(1 / 3.)) /
                 (1 / samples[a] + 1 / samples[b]);
      }
    }
  }
  if (!std::isfinite(total)) return std::nullopt;
  const double pairs = 0.5 * lanes * (lanes - 1.);
  return total / (static_cast<double>(pixels) * pairs * all_samples);
}

Image develop(const Film& film, const RenderBudget& budget, RenderStats& stats) {
  Image image = film.develop();
  if (budget.lanes == 0) return image;
  const FilmNoise noise = film.noise();
  stats.renders = noise.renders;
  stats.variance_of_mean = noise.variance_of_mean;
  const Image& variance = noise.image;
  const size_t pixels = static_cast<size_t>(image.width) * image.height;
  const size_t a = image.channels.size(), b = variance.channels.size();
  std::vector<float> data;
  data.reserve(pixels * (a + b));
  for (size_t p = 0; p < pixels; ++p) {
    data.insert(data.end(), &image.data[p * a], &image.data[p * a] + a);
    data.insert(data.end(), &variance.data[p * b], &variance.data[p * b] + b);
  }
  image.data = std::move(data);
  image.channels.insert(image.channels.end(), variance.channels.begin(), variance.channels.end());
  return image;
}

void render_passes(Passes& passes, Film& film, RenderContext& context,
                   const PassCallback& on_pass) {
  Progressive(passes, film, context, on_pass).run();
}

}  // namespace kinome
