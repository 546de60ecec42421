#include "light_guide.h"

#include <algorithm>
#include <cmath>

namespace kinome {
namespace {

/// Share of the draws that isn't guided.
constexpr double kDefensive = 0.25;
/// Of what is guided into a box, the share that doesn't tell its halves apart: what was found of no
/// use may have been missed, and more likely so beside what is of use.
constexpr double kBlur = 0.1;
/// A box is halved if so many draws of equal use would be as uncertain as its are.
constexpr double kLeastEffective = 6;
/// Of squared sums of parts: (kParts - 1) squares are expected by chance, with a deviation of
/// sqrt(2 (kParts - 1)).
constexpr int kParts = 8;
constexpr double kLeastDifference = 15;
/// Numbers have 24 bits: so many halvings of all axes together leave most of them.
constexpr int kMostHalvings = 24;
/// What is known of a source counts as much as that it is like all others from so many draws on.
constexpr double kTrustedDraws = 8;

}  // namespace

struct LightGuide::Builder {
  std::vector<Node>& nodes;

  struct Box {
    Numbers lo{0, 0, 0, 0};
    Numbers hi{1, 1, 1, 1};
    double volume = 1;
    float middle(int axis) const { return 0.5f * (lo[axis] + hi[axis]); }
  };

  static double sum_of(std::span<const Use> uses) {
    double sum = 0;
    for (const Use& use : uses) sum += use.use;
    return sum;
  }

  /// The axis along which use differs most between eighths of the box; -1: not worth it. Halves
  /// alone would not tell of what lies in the middle.
  static int best_axis(std::span<const Use> uses, const Box& box) {
    double sum = 0, squares = 0;
    std::array<std::array<double, kParts>, kAxes> parts{};
    std::array<float, kAxes> scale;
    for (int a = 0; a < kAxes; ++a) scale[a] = kParts / (box.hi[a] - box.lo[a]);
    for (const Use& use : uses) {
      sum += use.use;
      squares += static_cast<double>(use.use) * use.use;
      for (int a = 0; a < kAxes; ++a) {
        const auto part = static_cast<int>((use.at[a] - box.lo[a]) * scale[a]);
        parts[a][std::clamp(part, 0, kParts - 1)] += use.use;
      }
    }
    if (!(sum > 0) || sum * sum < kLeastEffective * squares) return -1;
    int best = -1;
    double most = kLeastDifference * squares;
    for (int a = 0; a < kAxes; ++a) {
      double of_parts = 0;
      for (const double part : parts[a]) of_parts += part * part;
      const double difference = kParts * of_parts - sum * sum;
      if (difference > most) {
        most = difference;
        best = a;
      }
    }
    return best;
  }

  /// `guided`: probability that draws are guided to the box. Returns that of being drawn there.
  double build(uint32_t node, std::span<Use> uses, const Box& box, double guided, int depth) {
    int axis = -1;
    if (depth < kMostHalvings) axis = best_axis(uses, box);
    if (axis < 0) {
      const double part = (1 - kDefensive) * guided + kDefensive * box.volume;
      nodes[node].below_part = static_cast<float>(part / box.volume);
      return part;
    }
    const float middle = box.middle(axis);
    const auto split = std::stable_partition(uses.begin(), uses.end(),
                                             [&](const Use& use) { return use.at[axis] < middle; });
    const auto begin = static_cast<uint32_t>(nodes.size());
    nodes.resize(nodes.size() + 2);
    nodes[node].axis = axis;
    nodes[node].below = begin;
    Box below = box, above = box;
    below.hi[axis] = above.lo[axis] = middle;
    below.volume = above.volume = box.volume / 2;
    const auto count = static_cast<size_t>(split - uses.begin());
    const double share = kBlur / 2 + (1 - kBlur) * sum_of(uses.first(count)) / sum_of(uses);
    const double first = build(begin, uses.first(count), below, guided * share, depth + 1);
    const double second =
        build(begin + 1, uses.subspan(count), above, guided * (1 - share), depth + 1);
    nodes[node].below_part = static_cast<float>(first / (first + second));
    return first + second;
  }
};

LightGuide::LightGuide(std::span<const float> shares, std::span<const Use> uses, uint32_t count) {
  std::vector<Use> sorted(uses.begin(), uses.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Use& a, const Use& b) { return a.source < b.source; });
  const double total = Builder::sum_of(sorted);
  if (!(total > 0) || !std::isfinite(total)) return;
  factor_.resize(shares.size());
  roots_.assign(shares.size(), kNoTree);
  double guided = 0;
  auto of_source = [&, begin = sorted.begin()](uint32_t source) mutable {
    const auto end =
        std::find_if(begin, sorted.end(), [&](const Use& use) { return use.source != source; });
    const std::span<Use> own(begin, end);
    begin = end;
    return own;
  };
  for (uint32_t s = 0; s < shares.size(); ++s) {
    const std::span<Use> own = of_source(s);
    const double sum = Builder::sum_of(own);
    const double expected = static_cast<double>(shares[s]) * count;
    const double trust = expected / (expected + kTrustedDraws);
    const double part = shares[s] * (1 - trust) + trust * sum / total;
    factor_[s] = static_cast<float>(part);
    guided += part;
    if (!(sum > 0)) continue;
    const auto root = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Builder{nodes_}.build(root, own, {}, 1, 0);
    if (nodes_[root].axis < 0) {
      nodes_.pop_back();
    } else {
      roots_[s] = root;
    }
  }
  double end = 0;
  for (uint32_t s = 0; s < shares.size(); ++s) {
    const double part = (1 - kDefensive) * factor_[s] / guided + kDefensive * shares[s];
    ends_.push_back(end += part);
    factor_[s] = shares[s] > 0 ? static_cast<float>(part / shares[s]) : 0.f;
  }
}

float LightGuide::warp(uint32_t source, Numbers& at) const {
  if (empty()) return 1;
  if (roots_[source] == kNoTree) return factor_[source];
  Numbers lo{0, 0, 0, 0}, width{1, 1, 1, 1};
  const Node* node = &nodes_[roots_[source]];
  while (node->axis >= 0) {
    const int axis = node->axis;
    float& u = at[axis];
    float& w = width[axis];
    const float p = node->below_part;
    w *= 0.5f;
    // Rounding must not leave the unit interval.
    if (u < p) {
      u = std::min(u / p, 0x1.fffffep-1f);
      node = &nodes_[node->below];
    } else {
      u = std::min((u - p) / (1 - p), 0x1.fffffep-1f);
      lo[axis] += w;
      node = &nodes_[node->below + 1];
    }
  }
  for (int a = 0; a < kAxes; ++a) at[a] = std::min(lo[a] + width[a] * at[a], 0x1.fffffep-1f);
  return factor_[source] * node->below_part;
}

}  // namespace kinome
