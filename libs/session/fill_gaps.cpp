#include "session/fill_gaps.h"

#include <algorithm>

#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "kinome/work_source.h"

namespace kinome {
namespace {

/// Longest time that filling may take: users who have interrupted a program won't wait longer.
constexpr double kMaxSeconds = 2;
/// The same for a group of processes, whose launcher waits less.
constexpr double kMaxSecondsInGroup = 0.3;
/// Mixed into the seed, so that the random numbers differ from those of the render.
constexpr uint64_t kFillSeed = 0x66696c6c;

using Gaps = std::vector<std::vector<bool>>;

Gaps gaps_of(const Film& film, size_t layers) {
  Gaps gaps;
  for (size_t i = 0; i < layers; ++i) gaps.push_back(film.gaps(static_cast<int>(i)));
  return gaps;
}

/// Restricts a render to the tiles that cover a gap.
class GapsOnly final : public WorkSource {
 public:
  /// `gaps`: see Film::gaps(), for each layer, over the window `crop`.
  GapsOnly(const Rect& crop, Gaps gaps) : crop_(crop), gaps_(std::move(gaps)) {}

  bool is_wanted(const Rect& pixels, int layer) const override {
    for (int y = std::max(pixels.y0, crop_.y0); y < std::min(pixels.y1, crop_.y1); ++y) {
      for (int x = std::max(pixels.x0, crop_.x0); x < std::min(pixels.x1, crop_.x1); ++x) {
        const size_t row = static_cast<size_t>(y - crop_.y0) * crop_.width();
        if (gaps_[layer][row + (x - crop_.x0)]) return true;
      }
    }
    return false;
  }

 private:
  const Rect crop_;
  const Gaps gaps_;
};

/// Number of pixels without samples in at least one layer.
double count(const Gaps& gaps) {
  double pixels = 0;
  for (size_t p = 0; p < gaps[0].size(); ++p) {
    pixels += std::any_of(gaps.begin(), gaps.end(), [p](const auto& layer) { return layer[p]; });
  }
  return pixels;
}

/// Predicts the time for `rays` camera rays; infinity if there were none so far. Includes the work
/// before the first tile, which is repeated.
double predicted_seconds(RenderContext& context, double begun, double rays) {
  RenderJob& job = context.job;
  const RenderStats& stats = job.stats();
  const auto so_far = static_cast<double>(stats.counters.rays[static_cast<int>(RayKind::kCamera)]);
  if (!(so_far > 0)) return kInfinity;
  const double first = stats.first_tile_seconds;
  // All processes of a group have rendered, but only one fills the gaps.
  const Scheduler& scheduler = context.scheduler;
  const double slower = static_cast<double>(scheduler.all_threads()) / scheduler.threads();
  return (first - begun) + (job.seconds() - first) * slower * rays / so_far;
}

}  // namespace

double share_of_gaps(const Integrator& integrator, const Film& film) {
  return count(gaps_of(film, integrator.layers().size())) / std::max(1, film.crop().area());
}

void fill_gaps(const Scene& scene, const Sensor& sensor, RenderContext& context, double begun) {
  const Integrator& integrator = scene.integrator();
  Film& film = sensor.film();
  RenderJob& job = context.job;
  RenderStats& stats = job.stats();
  const size_t layers = integrator.layers().size();
  const double pixels = std::max(1, film.crop().area());
  Gaps gaps = gaps_of(film, layers);
  const double missing = count(gaps);
  stats.missing = missing / pixels;
  if (missing == 0) return;
  const auto once = sensor.with_sample_count(1);
  const double rays = missing * once->sampler().sample_count();
  const double max_seconds = job.group() ? kMaxSecondsInGroup : kMaxSeconds;
  if (!(predicted_seconds(context, begun, rays) < max_seconds)) return;
  RenderOptions options;
  options.threads = context.scheduler.threads();
  options.seed = hash_words(job.seed(), kFillSeed);
  options.clock = [&job] { return job.seconds(); };
  RenderContext filler(options);
  GapsOnly source(film.crop(), std::move(gaps));
  filler.job.set_work_source(&source);
  filler.job.set_deadline(job.seconds() + max_seconds);
  film.set_lane(0);
  integrator.render(scene, *once, filler);
  stats.counters.add(filler.job.stats().counters);
  const double left = count(gaps_of(film, layers));
  stats.filled = (missing - left) / pixels;
  stats.missing = left / pixels;
}

void mark_gaps(const Film& film, Image& image) {
  const std::vector<bool> gaps = film.gaps(0);
  const auto& names = image.channels;
  if (std::find(gaps.begin(), gaps.end(), true) == gaps.end()) return;
  if (image.find_channel("A") >= 0) return;  // 0 at gaps already
  const size_t before = names.size();
  const size_t colors = names.at(0) == "Y" ? 1 : 3;
  std::vector<float> data;
  data.reserve(gaps.size() * (before + 1));
  for (size_t p = 0; p < gaps.size(); ++p) {
    const auto pixel = image.data.begin() + static_cast<std::ptrdiff_t>(p * before);
    data.insert(data.end(), pixel, pixel + static_cast<std::ptrdiff_t>(colors));
    data.push_back(gaps[p] ? 0.f : 1.f);
    data.insert(data.end(), pixel + static_cast<std::ptrdiff_t>(colors),
                pixel + static_cast<std::ptrdiff_t>(before));
  }
  image.data = std::move(data);
  image.channels.insert(image.channels.begin() + static_cast<std::ptrdiff_t>(colors), "A");
}

}  // namespace kinome
