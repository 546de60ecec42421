#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "batch.h"

namespace kinome {

/// A mix of two BSDFs by a weight.
class MixOfTwo : public Bsdf {
 public:
  using Two = std::array<std::shared_ptr<Bsdf>, 2>;
  MixOfTwo(std::shared_ptr<const Texture> weight, Two nested)
      : weight_(std::move(weight)), nested_(std::move(nested)) {}
  const NumberInput& weight() const { return weight_; }
  const Two& nested() const { return nested_; }

 private:
  NumberInput weight_;  ///< of the second BSDF
  Two nested_;
};

/// The mixes that are nested in a mix, itself included, and the other BSDFs that they mix: the
/// *leaves*. An object that is part of several mixes is a single node, so that each leaf is
/// evaluated only once. The number of paths from a mix to its leaves may be exponential in the
/// number of mixes, for example if each mix refers to the two before it.
class BlendGraph {
 public:
  struct Part {
    size_t node;
    Lobe lobes;
    bool is_new;  ///< true if no earlier part is the same node
  };
  struct Mix {
    const NumberInput* weight;
    std::array<Part, 2> parts;
  };

  /// `root` must outlive the graph.
  explicit BlendGraph(const MixOfTwo& root) {
    std::vector<const MixOfTwo*> mixes;
    std::map<const Bsdf*, size_t> nodes;
    add(root, mixes, nodes);
    std::reverse(mixes.begin(), mixes.end());
    for (size_t i = 0; i < leaves_.size(); ++i) nodes[leaves_[i]] = i;
    for (size_t i = 0; i < mixes.size(); ++i) nodes[mixes[i]] = leaves_.size() + i;
    std::vector<bool> is_known(nodes.size());
    for (const MixOfTwo* const mix : mixes) {
      Mix& added = mixes_.emplace_back(Mix{&mix->weight(), {}});
      for (size_t side = 0; side < 2; ++side) {
        const Bsdf& part = *mix->nested()[side];
        const size_t node = nodes[&part];
        added.parts[side] = {node, part.lobes(), !is_known[node]};
        is_known[node] = true;
      }
    }
  }

  /// Leaves in the order of their first occurrence. Leaf i is node i.
  const std::vector<const Bsdf*>& leaves() const { return leaves_; }
  /// All mixes, each before its parts. Mix i is node leaves().size() + i.
  const std::vector<Mix>& mixes() const { return mixes_; }
  size_t node_of_mix(size_t i) const { return leaves_.size() + i; }

 private:
  /// Adds leaves, and mixes each after its parts.
  void add(const Bsdf& bsdf, std::vector<const MixOfTwo*>& mixes,
           std::map<const Bsdf*, size_t>& nodes) {
    if (!nodes.emplace(&bsdf, 0).second) return;
    const auto* const mix = dynamic_cast<const MixOfTwo*>(&bsdf);
    if (!mix) {
      leaves_.push_back(&bsdf);
      return;
    }
    for (const auto& nested : mix->nested()) add(*nested, mixes, nodes);
    mixes.push_back(mix);
  }

  std::vector<const Bsdf*> leaves_;
  std::vector<Mix> mixes_;
};

/// Weights of the leaves of a BlendGraph, and the probabilities of sampling them, at points.
/// Functions of F take float for a single point, or wide::Float for points i, i + 1, … of a block.
class BlendShares {
 public:
  /// `lobes` are those that are evaluated or sampled.
  BlendShares(const BlendGraph& graph, Lobe lobes, const SurfaceInteraction& si)
      : BlendShares(graph, lobes, 1) {
    for (size_t m = 0; m < graph.mixes().size(); ++m) {
      set_parts<float>(m, graph.mixes()[m].weight->at(si), 0);
    }
  }
  BlendShares(const BlendGraph& graph, Lobe lobes, const SurfaceBlock& points)
      : BlendShares(graph, lobes, points.count) {
    for (size_t m = 0; m < graph.mixes().size(); ++m) {
      const NumberInput::Columns weights(*graph.mixes()[m].weight, points);
      wide::for_lanes(points.count, [&](size_t i) { set_parts<wide::Float>(m, weights[i], i); });
    }
  }

  template <class F>
  F weight(size_t node, size_t i) const {
    return load<F>(columns_[2 * node] + i);
  }
  template <class F>
  F probability(size_t node, size_t i) const {
    return load<F>(columns_[2 * node + 1] + i);
  }

  /// Choice between the two parts of a mix by a random number.
  template <class F>
  struct Choice {
    MaskOf<F> is_second;
    F u1;      ///< uniform random number for the chosen part
    F factor;  ///< weight of the part, divided by the probability of its choice
  };
  template <class F>
  Choice<F> choose(size_t mix, const F& u1, size_t i) const {
    const auto [weight, second] = shares_of(mix, load<F>(column_of_mix(mix) + i));
    const MaskOf<F> is_second = u1 < second;
    const F rescaled = select(is_second, u1 / second, (u1 - second) / (1.f - second));
    return {is_second, select(rescaled >= 0.f, min(rescaled, F(kOneMinusEpsilon)), F(0.f)),
            select(is_second, weight / second, (1.f - weight) / (1.f - second))};
  }

 private:
  BlendShares(const BlendGraph& graph, Lobe lobes, size_t count)
      : graph_(graph),
        lobes_(lobes),
        columns_(2 * graph.leaves().size() + 3 * graph.mixes().size(), count) {}

  float* column_of_mix(size_t mix) const {
    return columns_[2 * graph_.node_of_mix(graph_.mixes().size()) + mix];
  }

  /// Weight of the second part of a mix, and the probability of sampling it.
  template <class F>
  struct Shares {
    F weight, probability;
  };
  template <class F>
  Shares<F> shares_of(size_t mix, const F& weight) const {
    const auto& parts = graph_.mixes()[mix].parts;
    if (!any(lobes_ & parts[1].lobes)) return {weight, F(0.f)};
    return {weight, any(lobes_ & parts[0].lobes) ? weight : F(1.f)};
  }

  /// Adds the shares of a mix to those of its parts. `value` is the texture's.
  template <class F>
  void set_parts(size_t mix, const F& value, size_t i) const {
    const size_t node = graph_.node_of_mix(mix);
    const bool is_root = mix == 0;
    const F whole_weight = is_root ? F(1.f) : weight<F>(node, i);
    const F whole_probability = is_root ? F(1.f) : probability<F>(node, i);
    const Shares<F> second = shares_of(mix, clamped_share(value));
    store(second.weight, column_of_mix(mix) + i);
    add(graph_.mixes()[mix].parts[0],
        Shares<F>{whole_weight * (1.f - second.weight),
                  whole_probability * (1.f - second.probability)},
        i);
    add(graph_.mixes()[mix].parts[1],
        Shares<F>{whole_weight * second.weight, whole_probability * second.probability}, i);
  }
  template <class F>
  void add(const BlendGraph::Part& part, Shares<F> shares, size_t i) const {
    if (!part.is_new) {
      shares.weight = shares.weight + weight<F>(part.node, i);
      shares.probability = shares.probability + probability<F>(part.node, i);
    }
    store(shares.weight, columns_[2 * part.node] + i);
    store(shares.probability, columns_[2 * part.node + 1] + i);
  }

  const BlendGraph& graph_;
  Lobe lobes_;
  wide::ScratchColumns columns_;  ///< weight and probability of each node; weight of second parts
};

}  // namespace kinome
