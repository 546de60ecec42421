#include "clustered/product/visibility.h"

#include <algorithm>
#include <cmath>

#include "kinome/render_context.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

constexpr size_t kFanOut = 8;
/// Counts are in sixteenths of a record.
constexpr float kUnit = 1 / 16.f;
/// How many records a parent's share counts as.
constexpr float kShrinkage = 2;
/// The same of the share around a cell.
constexpr float kNeighbourShrinkage = 2;
/// Of very many cells, only those near on the curve are asked for how near they are.
constexpr size_t kWindow = 512;
/// Shares of a few records are pulled to 0 and 1, which is what most cells are.
constexpr float kSnap = 0.05f;
/// Variance that remains however certain a share seems, and that of its own uncertainty.
constexpr float kLeastVariance = 1e-4f;
constexpr float kDoubt = 0.0015f;
constexpr float kMixedDoubt = 0.01f;

}  // namespace

void Visibility::resize(size_t padded) {
  v.resize(padded);
  sigma.resize(padded);
  sigma_mixed.resize(padded);
}

void Visibility::reset() {
  std::fill(v.begin(), v.end(), 0.f);
  std::fill(sigma.begin(), sigma.end(), 1.f);
  std::fill(sigma_mixed.begin(), sigma_mixed.end(), 1.f);
}

CellNeighbours find_neighbours(const DistantCells& cells, const RenderContext& context) {
  const auto& axis = cells.axis();
  const size_t count = cells.size();
  CellNeighbours found;
  // Where there are too few cells, the rest are padding, which nobody has records of.
  for (auto& column : found.of) {
    column.assign(cells.padded_size(), static_cast<int32_t>(count));
  }
  context.parallel_for(count, [&](size_t c) {
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
    : neighbours_(neighbours), all_(padded_cells + kBlockLanes), visible_(all_.size()) {
  for (size_t size = padded_cells; size > 1;) {
    size = (size + kFanOut - 1) / kFanOut;
    levels_.push_back({std::vector<uint32_t>(size), std::vector<uint32_t>(size),
                       std::vector<float>(size)});
  }
}

void VisibilityLearner::begin() {
  std::fill(all_.begin(), all_.end(), 0u);
  std::fill(visible_.begin(), visible_.end(), 0u);
}

void VisibilityLearner::add(std::span<const VisibilityRecord> records, uint32_t weight) {
  for (const VisibilityRecord record : records) {
    all_[record.cell()] += weight;
    visible_[record.cell()] += record.visible() ? weight : 0;
  }
}

void VisibilityLearner::sum_up() {
  const auto sum = [](const uint32_t* children, size_t count, std::vector<uint32_t>& nodes) {
    for (size_t i = 0; i < nodes.size(); ++i) {
      uint32_t of_node = 0;
      const size_t end = std::min(count, (i + 1) * kFanOut);
      for (size_t k = i * kFanOut; k < end; ++k) of_node += children[k];
      nodes[i] = of_node;
    }
  };
  size_t count = all_.size() - kBlockLanes;
  const uint32_t *all = all_.data(), *visible = visible_.data();
  for (Level& level : levels_) {
    sum(all, count, level.all);
    sum(visible, count, level.visible);
    count = level.all.size();
    all = level.all.data();
    visible = level.visible.data();
  }
}

void VisibilityLearner::share_down() {
  const auto share = [](const Level& level, size_t i, float above, float shrinkage) {
    return (kUnit * static_cast<float>(level.visible[i]) + shrinkage * above) /
           (kUnit * static_cast<float>(level.all[i]) + shrinkage);
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
  sum_up();
  if (levels_.back().all[0] == 0) {
    out.reset();
    return;
  }
  share_down();
  using namespace wide;
  for_lanes(out.v.size(), [&](size_t c) {
    const Float all = kUnit * to_float(Uint::load(&all_[c]));
    const Float visible = kUnit * to_float(Uint::load(&visible_[c]));
    const Float p = (visible + kShrinkage * prior(c)) / (all + kShrinkage);
    const Float v = clamp((p - kSnap) / (1 - 2 * kSnap), Float(0.f), Float(1.f));
    const Float left = max(p - 2.f * p * v + v * v, Float(0.f));
    v.store(&out.v[c]);
    sqrt(left + kDoubt / (1.f + all) + kLeastVariance).store(&out.sigma[c]);
    sqrt(p + kMixedDoubt).store(&out.sigma_mixed[c]);
  });
}

/// What cells without records are taken for.
wide::Float VisibilityLearner::prior(size_t first) const {
  using namespace wide;
  const Int cell = iota() + Int(static_cast<int32_t>(first));
  const Float parent = gather(levels_.front().share.data(), shift_right<3>(cell));
  if (!neighbours_ || first >= neighbours_->of[0].size()) return parent;
  Uint all(0u), visible(0u);
  for (const Column<int32_t>& neighbour : neighbours_->of) {
    const Int k = Int::load(&neighbour[first]);
    all += gather(all_.data(), k);
    visible += gather(visible_.data(), k);
  }
  return (kUnit * to_float(visible) + kNeighbourShrinkage * parent) /
         (kUnit * to_float(all) + kNeighbourShrinkage);
}

}  // namespace kinome
