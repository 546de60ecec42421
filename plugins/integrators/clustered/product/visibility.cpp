#include "clustered/product/visibility.h"

#include <algorithm>
#include <cmath>

#include "kinome/render_context.h"

namespace kinome {
namespace {

constexpr size_t kFanOut = 8;
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
  std::array<uint16_t, CellNeighbours::kCount> none;
  none.fill(static_cast<uint16_t>(count));
  found.of.assign(cells.padded_size(), none);
  context.parallel_for(count, [&](size_t c) {
    const size_t first = c > kWindow ? c - kWindow : 0, end = std::min(count, c + kWindow + 1);
    std::array<float, CellNeighbours::kCount> cosines;
    cosines.fill(-2);
    auto& nearest = found.of[c];
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
      nearest[at] = static_cast<uint16_t>(k);
    }
  });
  return found;
}

VisibilityLearner::VisibilityLearner(size_t padded_cells, const CellNeighbours* neighbours)
    : neighbours_(neighbours), counts_(padded_cells) {
  for (size_t size = padded_cells; size > 1;) {
    size = (size + kFanOut - 1) / kFanOut;
    levels_.emplace_back(size);
  }
}

void VisibilityLearner::begin() {
  std::fill(counts_.begin(), counts_.end(), Count{});
}

void VisibilityLearner::add(std::span<const VisibilityRecord> records, uint32_t weight) {
  for (const VisibilityRecord record : records) {
    Count& count = counts_[record.cell()];
    count.all += weight;
    count.visible += record.visible() ? weight : 0;
  }
}

void VisibilityLearner::finish(Visibility& out) {
  for (size_t level = 0; level < levels_.size(); ++level) {
    std::vector<Node>& nodes = levels_[level];
    for (size_t i = 0; i < nodes.size(); ++i) {
      Node sum;
      const size_t children = level == 0 ? counts_.size() : levels_[level - 1].size();
      const size_t end = std::min(children, (i + 1) * kFanOut);
      for (size_t k = i * kFanOut; k < end; ++k) {
        if (level == 0) {
          sum.all += static_cast<float>(counts_[k].all) / 16;
          sum.visible += static_cast<float>(counts_[k].visible) / 16;
        } else {
          sum.all += levels_[level - 1][k].all;
          sum.visible += levels_[level - 1][k].visible;
        }
      }
      nodes[i] = sum;
    }
  }
  // Downward: a node's sums become its share.
  Node& root = levels_.back().front();
  if (root.all == 0) {
    out.reset();
    return;
  }
  root.visible = (root.visible + 0.5f) / (root.all + 1);
  for (size_t level = levels_.size() - 1; level-- > 0;) {
    for (size_t i = 0; i < levels_[level].size(); ++i) {
      Node& node = levels_[level][i];
      const float parent = levels_[level + 1][i / kFanOut].visible;
      node.visible = (node.visible + kShrinkage * parent) / (node.all + kShrinkage);
    }
  }
  for (size_t c = 0; c < counts_.size(); ++c) {
    const float all = static_cast<float>(counts_[c].all) / 16;
    const float visible = static_cast<float>(counts_[c].visible) / 16;
    const float p = (visible + kShrinkage * prior(c)) / (all + kShrinkage);
    const float v = std::clamp((p - kSnap) / (1 - 2 * kSnap), 0.f, 1.f);
    out.v[c] = v;
    out.sigma[c] =
        std::sqrt(std::max(p - 2 * p * v + v * v, 0.f) + kDoubt / (1 + all) + kLeastVariance);
    out.sigma_mixed[c] = std::sqrt(p + kMixedDoubt);
  }
}

/// What a cell without records is taken for.
float VisibilityLearner::prior(size_t cell) const {
  const float parent = levels_.front()[cell / kFanOut].visible;
  if (!neighbours_ || cell >= neighbours_->of.size()) return parent;
  uint32_t all = 0, visible = 0;
  for (const uint16_t k : neighbours_->of[cell]) {
    all += counts_[k].all;
    visible += counts_[k].visible;
  }
  return (static_cast<float>(visible) / 16 + kNeighbourShrinkage * parent) /
         (static_cast<float>(all) / 16 + kNeighbourShrinkage);
}

}  // namespace kinome
