#include "clustered/product/lights/light_guide.h"

#include <algorithm>
#include <cmath>

#include "kinome/math.h"

namespace kinome {
namespace {

/// Share of the draws that isn't guided, neither to a source nor within it.
constexpr double kDefensive = 0.25;
/// Share of a box's guided draws that is divided equally between its halves. Draws may have missed
/// useful light in a half, most likely beside useful light.
constexpr double kBlur = 0.1;
/// Minimum effective sample size of the draws in a box that is halved.
constexpr double kMinEffectiveDrawsOfBox = 6;
/// Number of parts of a box along each axis that are compared.
constexpr int kParts = 8;
/// Minimum difference between the parts of a box that is halved, in units of the sum of squared
/// uses. By chance, the expected value is kParts - 1 = 7, the deviation sqrt(2 (kParts - 1)) = 3.7.
constexpr double kMinDifference = 15;
/// Maximum depth of a tree. Random numbers have 24 bits, and each halving uses one bit.
constexpr int kMaxHalvings = 24;
/// Number of draws from which the learned probability of a source has more weight than that without
/// a guide.
constexpr double kTrustedDraws = 8;

}  // namespace

struct LightGuide::Builder {
  std::vector<Node>& nodes;
  double defensive;  ///< share of the source's draws that isn't guided

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

  /// Returns the axis along which use differs most between eighths of the box, or -1 if the box
  /// should not be halved. A comparison of halves would miss a peak in the middle.
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
    if (!(sum > 0) || sum * sum < kMinEffectiveDrawsOfBox * squares) return -1;
    int best = -1;
    double most = kMinDifference * squares;
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

  /// Builds the subtree of a box. `guided` is the probability that a guided draw is in the box.
  /// Returns the probability that any draw is in the box.
  double build(uint32_t node, std::span<Use> uses, const Box& box, double guided, int depth) {
    int axis = -1;
    if (depth < kMaxHalvings) axis = best_axis(uses, box);
    if (axis < 0) {
      const double part = (1 - defensive) * guided + defensive * box.volume;
      nodes[node].value = static_cast<float>(part / box.volume);
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
    nodes[node].value = static_cast<float>(first / (first + second));
    return first + second;
  }
};

LightGuide::LightGuide(std::span<const float> shares, std::span<const Use> uses, uint32_t count) {
  std::vector<Use> sorted(uses.begin(), uses.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Use& a, const Use& b) { return a.source < b.source; });
  const double total = Builder::sum_of(sorted);
  if (!(total > 0) || !std::isfinite(total)) return;
  const auto sources = static_cast<uint32_t>(shares.size());
  std::vector<std::span<Use>> own(sources);
  std::vector<double> parts(sources);
  double guided = 0;
  auto begin = sorted.begin();
  for (uint32_t s = 0; s < sources; ++s) {
    const auto end =
        std::find_if(begin, sorted.end(), [&](const Use& use) { return use.source != s; });
    own[s] = {begin, end};
    begin = end;
    // The expected number without a guide is used, because the actual number is random.
    const double expected = static_cast<double>(shares[s]) * count;
    const double trust = expected / (expected + kTrustedDraws);
    parts[s] = shares[s] * (1 - trust) + trust * Builder::sum_of(own[s]) / total;
    guided += parts[s];
  }
  factor_.resize(sources);
  roots_.assign(sources, kNoTree);
  double end = 0;
  for (uint32_t s = 0; s < sources; ++s) {
    const double defensive = kDefensive * shares[s];
    const double part = (1 - kDefensive) * parts[s] / guided + defensive;
    ends_.push_back(end += part);
    factor_[s] = shares[s] > 0 ? static_cast<float>(part / shares[s]) : 0.f;
    if (!(Builder::sum_of(own[s]) > 0)) continue;
    const auto root = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Builder{nodes_, defensive / part}.build(root, own[s], {}, 1, 0);
    if (nodes_[root].axis < 0) {
      nodes_.pop_back();
    } else {
      roots_[s] = root;
    }
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
    const float p = node->value;
    w *= 0.5f;
    // Clamped, because rounding could give 1.
    if (u < p) {
      u = std::min(u / p, kOneMinusEpsilon);
      node = &nodes_[node->below];
    } else {
      u = std::min((u - p) / (1 - p), kOneMinusEpsilon);
      lo[axis] += w;
      node = &nodes_[node->below + 1];
    }
  }
  for (int a = 0; a < kAxes; ++a) at[a] = std::min(lo[a] + width[a] * at[a], kOneMinusEpsilon);
  return factor_[source] * node->value;
}

}  // namespace kinome
