#include "cryptomatte.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "kinome/stats.h"
#include "transport/blocks_of_tile.h"
#include "transport/camera.h"

namespace kinome {
namespace {

/// Key of the samples. It must not depend on the seed of a pass.
constexpr uint64_t kSeed = 0x6d61747465;

/// Ids of a pixel with the sums of their weights, in the order in which they were hit.
struct Histogram {
  struct Entry {
    float id;
    double weight;
  };
  std::vector<Entry> entries;
  double sum = 0;  ///< of the weights of all samples

  void add(float id, double weight) {
    const auto same = [id](const Entry& entry) { return entry.id == id; };
    const auto found = std::find_if(entries.begin(), entries.end(), same);
    if (found != entries.end()) {
      found->weight += weight;
    } else {
      entries.push_back({id, weight});
    }
  }
  /// Appends pairs of id and coverage, the largest first, and zeros up to `levels` pairs.
  void append_levels(int levels, std::vector<float>& values) {
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return a.weight != b.weight ? a.weight > b.weight : a.id < b.id;
    });
    for (size_t i = 0; i < static_cast<size_t>(levels); ++i) {
      // Filters with negative lobes may give negative sums.
      const bool is_covered = i < entries.size() && entries[i].weight > 0 && sum > 0;
      values.push_back(is_covered ? entries[i].id : 0.f);
      values.push_back(is_covered ? static_cast<float>(entries[i].weight / sum) : 0.f);
    }
  }
};

/// Coverage of the pixels of a tile. One per thread.
class CoverageOfTile {
 public:
  CoverageOfTile(const transport::SceneTable& table, const Sensor& sensor,
                 const std::vector<std::vector<float>>& ids)
      : film_(sensor.film()), ids_(ids), camera_(table, sensor, transport::kBlockSamples, false) {}

  void render(Tile& tile, uint32_t samples, int levels) {
    const StageTimer timer(tile.counters.stage_seconds["cryptomatte"]);
    pixels_ = intersected(tile.pixels, film_.crop());
    if (pixels_.width() <= 0 || pixels_.height() <= 0) return;
    histograms_.assign(ids_.size() * static_cast<size_t>(pixels_.area()), {});
    const int border = static_cast<int>(std::ceil(film_.filter().radius() - 0.5f));
    const Rect around{pixels_.x0 - border, pixels_.y0 - border, pixels_.x1 + border,
                      pixels_.y1 + border};
    transport::for_each_block(intersected(around, film_.sampled()), 0, samples, kSeed,
                              [&](const PixelSamples& block) {
                                camera_.trace_rays(block, tile.counters);
                                for (size_t i = 0; i < block.count(); ++i) add(i);
                              });
    std::vector<float> values;
    for (int y = pixels_.y0; y < pixels_.y1; ++y) {
      for (int x = pixels_.x0; x < pixels_.x1; ++x) {
        values.clear();
        for (size_t k = 0; k < ids_.size(); ++k) at(x, y, k).append_levels(levels, values);
        tile.film.add_pixel(x, y, values);
      }
    }
  }

 private:
  static Rect intersected(const Rect& a, const Rect& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
  }
  Histogram& at(int x, int y, size_t kind) {
    const auto pixel =
        static_cast<size_t>(y - pixels_.y0) * pixels_.width() + static_cast<size_t>(x - pixels_.x0);
    return histograms_[pixel * ids_.size() + kind];
  }

  /// Adds ray i of the block to all pixels that the filter reaches.
  void add(size_t i) {
    const ReconstructionFilter& filter = film_.filter();
    const float radius = filter.radius();
    const Vec2 position = camera_.film_position().at(i);
    const uint32_t shape = camera_.rays()[i / kBlockLanes].shape[i % kBlockLanes];
    const auto first = [radius](float p) { return static_cast<int>(std::ceil(p - radius - 0.5f)); };
    const auto last = [radius](float p) { return static_cast<int>(std::floor(p + radius - 0.5f)); };
    const int x1 = std::min(last(position.x), pixels_.x1 - 1);
    const int y1 = std::min(last(position.y), pixels_.y1 - 1);
    for (int y = std::max(first(position.y), pixels_.y0); y <= y1; ++y) {
      const double weight_y = filter.eval(static_cast<float>(y) + 0.5f - position.y);
      for (int x = std::max(first(position.x), pixels_.x0); x <= x1; ++x) {
        const double weight = weight_y * filter.eval(static_cast<float>(x) + 0.5f - position.x);
        if (weight == 0) continue;
        for (size_t k = 0; k < ids_.size(); ++k) {
          Histogram& histogram = at(x, y, k);
          histogram.sum += weight;
          if (shape != kNoHit) histogram.add(ids_[k][shape], weight);
        }
      }
    }
  }

  const Film& film_;
  const std::vector<std::vector<float>>& ids_;  ///< of each kind, by shape
  transport::Camera camera_;
  Rect pixels_;
  std::vector<Histogram> histograms_;  ///< by pixel, then by kind
};

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
  const std::unique_ptr<Sensor> own = sensor.with_sample_count(samples_);
  transport::Workers<CoverageOfTile> workers;
  context.scheduler.for_each_tile(
      film,
      [&](Tile& tile) {
        workers.with_one([&] { return std::make_unique<CoverageOfTile>(table, *own, ids); },
                         [&](CoverageOfTile& coverage) {
                           coverage.render(tile, own->sampler().sample_count(), levels_);
                         });
      },
      layer);
}

}  // namespace kinome
