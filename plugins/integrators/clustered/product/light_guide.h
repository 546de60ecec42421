#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kinome {

/// Which sources' light, and which part of it, is of use to the camera: a density over sources and
/// over the numbers in the unit cube that a source turns into a place and a direction. Learned from
/// draws of its own, then fixed. Constant on the leaves of a kd tree for each source, with a floor:
/// nothing is left out. Immutable; thread-safe.
class LightGuide {
 public:
  static constexpr int kAxes = 4;
  using Numbers = std::array<float, kAxes>;
  /// A draw, and what it was found to be of use for, divided by its density.
  struct Use {
    uint32_t source;
    Numbers at;
    float use;
  };

  /// Leaves everything as it is.
  LightGuide() = default;
  /// shares: probabilities of the sources without a guide, which sum to 1. uses: of a number of
  /// draws `count`, those that landed anywhere; the others were of no use.
  LightGuide(std::span<const float> shares, std::span<const Use> uses, uint32_t count);

  bool empty() const { return factor_.empty(); }
  /// Running sums of the probabilities of sources; not of an empty guide.
  const std::vector<double>& ends() const { return ends_; }
  /// Moves numbers of a source, uniform in the unit cube, to where they are of use. Returns the
  /// density there, of source and numbers, over that without a guide.
  float warp(uint32_t source, Numbers& at) const;

 private:
  struct Node {
    int axis = -1;       ///< -1: a leaf
    float value = 0;     ///< probability of the half below the middle; of a leaf: density
    uint32_t below = 0;  ///< the other half is the next
  };
  struct Builder;

  std::vector<double> ends_;
  std::vector<float> factor_;    ///< of each source's probability
  std::vector<uint32_t> roots_;  ///< of each source, or kNoTree
  std::vector<Node> nodes_;
  static constexpr uint32_t kNoTree = ~0u;
};

}  // namespace kinome
