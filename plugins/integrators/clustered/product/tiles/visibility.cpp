#include "clustered/product/tiles/visibility.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "clustered/kernels/lane_blocks.h"
#include "kinome/scheduler.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

constexpr size_t kFanOut = 8;
/// Counts are in sixteenths of a record. Each takes half of a word.
constexpr float kUnit = 1 / 16.f;
constexpr int kHalf = 16;
/// Number of records that a parent's share counts as.
constexpr float kShrinkage = 2;
/// Number of records that the share of a cell's neighbours counts as.
constexpr float kNeighbourShrinkage = 2;
/// Maximum distance along the curve at which neighbours are searched, which limits the time for
/// very many cells.
constexpr size_t kWindow = 512;
/// Shares within this distance of 0 and 1 are rounded to them, because most cells are fully hidden
/// or visible.
constexpr float kSnap = 0.05f;
/// Minimum variance, and the variance of the share itself for one record.
constexpr float kMinVariance = 1e-4f;
constexpr float kShareVariance = 0.0015f;
constexpr float kMixedVariance = 0.01f;

/// Return the number of records, and the sum of their shares.
wide::Float all_of(wide::Uint counts) {
  const wide::Int lower = wide::as_int(counts) & wide::Int(VisibilityLearner::kMaxWeight);
  return kUnit * to_float(wide::as_uint(lower));
}
wide::Float visible_of(wide::Uint counts) {
  return kUnit * to_float(wide::shift_right<kHalf>(counts));
}

}  // namespace

void Visibility::reset() {
  std::fill(v.begin(), v.end(), 0.f);
  std::fill(sigma.begin(), sigma.end(), 1.f);
  std::fill(sigma_mixed.begin(), sigma_mixed.end(), 1.f);
}

CellNeighbours find_neighbours(const DistantCells& cells, const Scheduler& scheduler) {
  const auto& axis = cells.axis();
  const size_t count = cells.size();
  CellNeighbours found;
  // If there are too few cells, the missing neighbours are padding, which has no records.
  for (auto& column : found.of) {
    column.assign(cells.padded_size(), static_cast<int32_t>(count));
  }
  scheduler.parallel_for(count, [&](size_t c) {
    const size_t first = c > kWindow ? c - kWindow : 0, end = std::min(count, c + kWindow + 1);
    std::array<float, CellNeighbours::kCount> cosines;
    cosines.fill(-2);
    std::array<int32_t, CellNeighbours::kCount> nearest;
    nearest.fill(static_cast<int32_t>(count));
    for (size_t k = first; k < end; ++k) {
      const float cosine =
          axis[0][c] * axis[0][k] + axis[1][c] * axis[1][k] + axis[2][c] * axis[2][k];
      if (k == c || cosine <= cosines.back()) continue;
      size_t at = cosines.size() - 1;
      for (; at > 0 && cosine > cosines[at - 1]; --at) {
        cosines[at] = cosines[at - 1];
        nearest[at] = nearest[at - 1];
      }
      cosines[at] = cosine;
      nearest[at] = static_cast<int32_t>(k);
    }
    for (size_t i = 0; i < nearest.size(); ++i) found.of[i][c] = nearest[i];
  });
  return found;
}

VisibilityLearner::VisibilityLearner(size_t padded_cells, const CellNeighbours* neighbours)
    : neighbours_(neighbours),
      counts_(padded_cells + kBlockLanes),
      all_blocks_(padded(padded_cells) / kBlockLanes) {
  std::iota(all_blocks_.begin(), all_blocks_.end(), 0u);
  for (size_t size = padded_cells; size > 1;) {
    size = (size + kFanOut - 1) / kFanOut;
    levels_.push_back({std::vector<Count>(size), std::vector<float>(size)});
  }
}

void VisibilityLearner::begin() {
  std::fill(counts_.begin(), counts_.end(), 0u);
  weight_ = 0;
  shares_ = squares_ = 0;
}

void VisibilityLearner::add(std::span<const VisibilityRecord> records, uint32_t weight) {
  if (weight == 0) return;
  records = records.first(std::min<size_t>(records.size(), (kMaxWeight - weight_) / weight));
  weight_ += static_cast<uint32_t>(records.size()) * weight;
  constexpr uint32_t kWhole = VisibilityRecord::kWhole;
  uint32_t shares = 0, squares = 0;
  for (const VisibilityRecord record : records) {
    const uint32_t share = record.share();
    counts_[record.cell()] += (weight * share + kWhole / 2) / kWhole << kHalf | weight;
    shares += share;
    squares += share * share;
  }
  shares_ += uint64_t{weight} * shares;
  squares_ += uint64_t{weight} * squares;
}

/// The halves of a sum can't overflow, because both are at most kMaxWeight.
void VisibilityLearner::sum_up() {
  size_t count = counts_.size() - kBlockLanes;
  const Count* children = counts_.data();
  for (Level& level : levels_) {
    for (size_t i = 0; i < level.counts.size(); ++i) {
      Count of_node = 0;
      const size_t end = std::min(count, (i + 1) * kFanOut);
      for (size_t k = i * kFanOut; k < end; ++k) of_node += children[k];
      level.counts[i] = of_node;
    }
    count = level.counts.size();
    children = level.counts.data();
  }
}

void VisibilityLearner::estimate_shares() {
  const auto share = [](const Level& level, size_t i, float above, float shrinkage) {
    const Count count = level.counts[i];
    return (kUnit * static_cast<float>(count >> kHalf) + shrinkage * above) /
           (kUnit * static_cast<float>(count & kMaxWeight) + shrinkage);
  };
  levels_.back().share[0] = share(levels_.back(), 0, 0.5f, 1);
  for (size_t k = levels_.size() - 1; k-- > 0;) {
    Level& level = levels_[k];
    for (size_t i = 0; i < level.share.size(); ++i) {
      level.share[i] = share(level, i, levels_[k + 1].share[i / kFanOut], kShrinkage);
    }
  }
}

void VisibilityLearner::finish(Visibility& out) {
  finish(all_blocks_, out);
}

void VisibilityLearner::finish(const CellBlocks& blocks, const Vec3& normal, float sine,
                               Visibility& out) {
  blocks.find_facing(normal, sine, facing_);
  facing_.insert(facing_.end(), all_blocks_.begin() + static_cast<ptrdiff_t>(blocks.size()),
                 all_blocks_.end());
  finish(facing_, out);
}

void VisibilityLearner::finish(std::span<const uint32_t> blocks, Visibility& out) {
  if (blocks.size() < all_blocks_.size() || weight_ == 0) out.reset();
  if (weight_ == 0) return;
  sum_up();
  estimate_shares();
  using namespace wide;
  // Mean square divided by the mean of what arrives. It is 1 if surfaces either block light or
  // don't change it.
  const float weakened =
      shares_ > 0 ? static_cast<float>(static_cast<double>(squares_) /
                                       (VisibilityRecord::kWhole * static_cast<double>(shares_)))
                  : 1.f;
  const bool is_weakened = weakened < 1;
  for_lanes_of_blocks(blocks, [&](size_t c) {
    const Uint count = Uint::load(&counts_[c]);
    const Float all = all_of(count), visible = visible_of(count);
    const Float p = (visible + kShrinkage * prior(c)) / (all + kShrinkage);
    const Float share = is_weakened ? p / weakened : p;
    const Float snapped = clamp((share - kSnap) / (1 - 2 * kSnap), Float(0.f), Float(1.f));
    const Float v = is_weakened ? snapped * weakened : snapped;
    const Float square = is_weakened ? p * weakened : p;
    const Float left = max(square - 2.f * p * v + v * v, Float(0.f));
    v.store(&out.v[c]);
    sqrt(left + kShareVariance / (1.f + all) + kMinVariance).store(&out.sigma[c]);
    sqrt(p + kMixedVariance).store(&out.sigma_mixed[c]);
  });
}

/// Returns the visibility that is assumed for cells without records.
wide::Float VisibilityLearner::prior(size_t first) const {
  using namespace wide;
  const Int cell = iota() + Int(static_cast<int32_t>(first));
  const Float parent = gather(levels_.front().share.data(), shift_right<3>(cell));
  if (!neighbours_ || first >= neighbours_->of[0].size()) return parent;
  Uint around(0u);
  for (const Column<int32_t>& neighbour : neighbours_->of) {
    around += gather(counts_.data(), Int::load(&neighbour[first]));
  }
  return (visible_of(around) + kNeighbourShrinkage * parent) /
         (all_of(around) + kNeighbourShrinkage);
}

}  // namespace kinome
