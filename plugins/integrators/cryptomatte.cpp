#include "cryptomatte.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>

#include "kinome/log.h"
#include "kinome/stats.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/camera/camera.h"

namespace kinome {
namespace {

/// Bounds on the camera rays per pixel, unless they are given. More would hardly improve the
/// mattes.
constexpr uint32_t kMinSamples = 4;
constexpr uint32_t kMaxSamples = 16;
/// Maximum shares of the remaining time of a render with a time limit: of the default number of
/// rays, and of a given one.
constexpr double kMaxTimeShare = 0.1, kMaxTimeShareOfGiven = 0.5;

/// Key of the samples. It must not depend on the seed of a pass.
constexpr uint64_t kSeed = 0x6d61747465;

/// Ids or shapes of a pixel with the sums of their weights, in the order in which they were hit.
template <class Key>
struct Histogram {
  struct Entry {
    Key key;
    double weight;
  };
  std::vector<Entry> entries;

  void add(Key key, double weight) {
    const auto same = [key](const Entry& entry) { return entry.key == key; };
    const auto found = std::find_if(entries.begin(), entries.end(), same);
    if (found != entries.end()) {
      found->weight += weight;
    } else {
      entries.push_back({key, weight});
    }
  }
};

/// Shapes of a pixel.
struct PixelShapes {
  Histogram<uint32_t> shapes;
  double sum = 0;  ///< of the weights of all samples

  /// Appends pairs of id and coverage, the largest first, and zeros up to `levels` pairs.
  void append_levels(const std::vector<float>& ids, int levels, std::vector<float>& values) const {
    Histogram<float> coverage;
    for (const auto& [shape, weight] : shapes.entries) coverage.add(ids[shape], weight);
    auto& entries = coverage.entries;
    std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
      return a.weight != b.weight ? a.weight > b.weight : a.key < b.key;
    });
    for (size_t i = 0; i < static_cast<size_t>(levels); ++i) {
      // Filters with negative lobes may give negative sums.
      const bool is_covered = i < entries.size() && entries[i].weight > 0 && sum > 0;
      values.push_back(is_covered ? entries[i].key : 0.f);
      values.push_back(is_covered ? static_cast<float>(entries[i].weight / sum) : 0.f);
    }
  }
};

/// Pixels of one axis that a sample reaches, and the filter's weights there.
struct ReachedPixels {
  int first = 0;
  std::vector<double> weights;

  /// Sets the pixels of [low, high) that the filter around `position` reaches.
  void set(const ReconstructionFilter& filter, float position, int low, int high) {
    const float radius = filter.radius();
    first = std::max(static_cast<int>(std::ceil(position - radius - 0.5f)), low);
    const int last = std::min(static_cast<int>(std::floor(position + radius - 0.5f)), high - 1);
    weights.clear();
    for (int i = first; i <= last; ++i) {
      weights.push_back(filter.eval(static_cast<float>(i) + 0.5f - position));
    }
  }
};

/// Coverage of the pixels of a tile. One per thread.
class CoverageOfTile {
 public:
  CoverageOfTile(const transport::SceneTable& table, const Sensor& sensor,
                 const std::vector<std::vector<float>>& ids)
      : film_(sensor.film()), ids_(ids), camera_(table, sensor, transport::kBlockSamples, false) {}

  /// Finds the shapes of the pixels that are in the crop window.
  void trace(const Rect& pixels, uint32_t samples, RenderCounters& counters) {
    pixels_ = intersected(pixels, film_.crop());
    if (pixels_.width() <= 0 || pixels_.height() <= 0) return;
    shapes_.assign(static_cast<size_t>(pixels_.area()), {});
    const int border = static_cast<int>(std::ceil(film_.filter().radius() - 0.5f));
    const Rect around{pixels_.x0 - border, pixels_.y0 - border, pixels_.x1 + border,
                      pixels_.y1 + border};
    transport::for_each_block(intersected(around, film_.sampled()), 0, samples, kSeed,
                              [&](const PixelSamples& block) {
                                camera_.trace_rays(block, counters);
                                for (size_t i = 0; i < block.count(); ++i) add(i);
                              });
  }

  void render(Tile& tile, uint32_t samples, int levels) {
    const StageTimer timer(tile.counters.stage_seconds["cryptomatte"]);
    trace(tile.pixels, samples, tile.counters);
    std::vector<float> values;
    for (int y = pixels_.y0; y < pixels_.y1; ++y) {
      for (int x = pixels_.x0; x < pixels_.x1; ++x) {
        values.clear();
        for (const std::vector<float>& ids : ids_) at(x, y).append_levels(ids, levels, values);
        tile.film.add_pixel(x, y, values);
      }
    }
  }

 private:
  static Rect intersected(const Rect& a, const Rect& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
  }
  PixelShapes& at(int x, int y) {
    return shapes_[static_cast<size_t>(y - pixels_.y0) * static_cast<size_t>(pixels_.width()) +
                   static_cast<size_t>(x - pixels_.x0)];
  }

  /// Adds ray i of the block to all pixels that the filter reaches.
  void add(size_t i) {
    const Vec2 position = camera_.film_position().at(i);
    const uint32_t shape = camera_.rays()[i / kBlockLanes].shape[i % kBlockLanes];
    columns_.set(film_.filter(), position.x, pixels_.x0, pixels_.x1);
    rows_.set(film_.filter(), position.y, pixels_.y0, pixels_.y1);
    for (size_t y = 0; y < rows_.weights.size(); ++y) {
      for (size_t x = 0; x < columns_.weights.size(); ++x) {
        const double weight = rows_.weights[y] * columns_.weights[x];
        if (weight == 0) continue;
        PixelShapes& pixel =
            at(columns_.first + static_cast<int>(x), rows_.first + static_cast<int>(y));
        pixel.sum += weight;
        if (shape != kNoHit) pixel.shapes.add(shape, weight);
      }
    }
  }

  const Film& film_;
  const std::vector<std::vector<float>>& ids_;  ///< of each kind, by shape
  transport::Camera camera_;
  Rect pixels_;
  std::vector<PixelShapes> shapes_;  ///< by pixel
  ReachedPixels columns_, rows_;     ///< of the current ray
};

/// Measures the time of one camera ray per pixel, by the tile at the centre of the image.
double seconds_per_sample(const transport::SceneTable& table, const Sensor& sensor,
                          const std::vector<std::vector<float>>& ids,
                          const RenderContext& context) {
  const Rect crop = sensor.film().crop();
  const int x = (crop.x0 + crop.x1) / 2, y = (crop.y0 + crop.y1) / 2;
  const Rect pixels{x, y, std::min(x + kTileSize, crop.x1), std::min(y + kTileSize, crop.y1)};
  RenderCounters counters;
  CoverageOfTile coverage(table, sensor, ids);
  const double start = context.job.seconds();
  coverage.trace(pixels, 1, counters);
  const double per_pixel = (context.job.seconds() - start) / std::max(1, pixels.area());
  return per_pixel * crop.area() / context.scheduler.all_threads();
}

}  // namespace

Cryptomatte::Cryptomatte(std::vector<CryptomatteKind> kinds, int levels, uint32_t samples)
    : kinds_(std::move(kinds)), levels_(levels + levels % 2), samples_(samples) {}

std::vector<std::string> Cryptomatte::channels() const {
  std::vector<std::string> names;
  for (const CryptomatteKind kind : kinds_) {
    const std::vector<std::string> own = cryptomatte_channels(kind, levels_);
    names.insert(names.end(), own.begin(), own.end());
  }
  return names;
}

double Cryptomatte::share_of_time() const {
  return samples_ > 0 ? kMaxTimeShareOfGiven : kMaxTimeShare;
}

uint32_t Cryptomatte::sample_count(const Sensor& sensor, RenderContext& context,
                                   const std::function<double()>& seconds_of_sample) const {
  const RenderBudget& budget = context.job.budget();
  if (budget.seconds > 0) {
    const uint32_t max_count = samples_ > 0 ? samples_ : kMaxSamples;
    const auto count = static_cast<uint32_t>(context.job.decide([&] {
      const double left = std::max(0., budget.seconds - context.job.seconds());
      const double affordable = share_of_time() * left / std::max(1e-9, seconds_of_sample());
      return std::clamp(std::floor(affordable), 1., static_cast<double>(max_count));
    }));
    if (count < samples_) {
      log_warn("crypto_samples=" + std::to_string(samples_) +
               " takes more than half of the time limit: the mattes have at most " +
               std::to_string(count) + " rays per pixel");
    }
    return count;
  }
  if (samples_ > 0) return samples_;
  if (budget.rel_mse > 0) return kMaxSamples;
  return std::clamp(sensor.sampler().sample_count(), kMinSamples, kMaxSamples);
}

void Cryptomatte::render(const Scene& scene, const Sensor& sensor, RenderContext& context,
                         int layer) const {
  Film& film = sensor.film();
  const bool is_missing = context.job.decide([&] {
    const std::vector<bool> gaps = film.gaps(film.first_layer() + layer);
    return std::find(gaps.begin(), gaps.end(), true) != gaps.end() ? 1. : 0.;
  }) != 0;
  if (!is_missing) return;
  std::vector<std::vector<float>> ids;
  for (const CryptomatteKind kind : kinds_) {
    std::vector<float>& of_kind = ids.emplace_back();
    for (const std::string& name : cryptomatte_names(scene, kind)) {
      of_kind.push_back(cryptomatte_id(cryptomatte_hash(name)));
    }
  }
  const transport::SceneTable table(scene);
  const auto seconds_of_sample = [&] { return seconds_per_sample(table, sensor, ids, context); };
  const std::unique_ptr<Sensor> own =
      sensor.with_sample_count(sample_count(sensor, context, seconds_of_sample));
  const double start = context.job.seconds();
  // Tiles that are late get a single ray per pixel.
  const double allowed = share_of_time() * (context.job.budget().seconds - start);
  std::atomic<int> pixels_done = 0;
  const auto is_late = [&](int pixels) {
    const double share = static_cast<double>(pixels_done + pixels) / film.crop().area();
    return allowed > 0 && context.job.seconds() - start > share * allowed;
  };
  transport::Workers<CoverageOfTile> workers;
  context.scheduler.for_each_tile(
      film,
      [&](Tile& tile) {
        workers.with_one([&] { return std::make_unique<CoverageOfTile>(table, *own, ids); },
                         [&](CoverageOfTile& coverage) {
                           const int pixels = tile.pixels.area();
                           const uint32_t samples =
                               is_late(pixels) ? 1 : own->sampler().sample_count();
                           coverage.render(tile, samples, levels_);
                           pixels_done += pixels;
                         });
      },
      layer);
}

}  // namespace kinome
