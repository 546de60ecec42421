#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kinome {

/// Guide for emission: a learned density of light that contributes to the image. It is a density
/// over sources, and over the random numbers that a source turns into a position and a direction.
/// Piecewise constant on the leaves of one kd tree per source, with a lower bound above 0. Learned
/// from separate draws. Immutable; thread-safe.
class LightGuide {
 public:
  static constexpr int kAxes = 4;
  using Numbers = std::array<float, kAxes>;
  /// Contribution of a draw to the image, divided by the density of the draw.
  struct Use {
    uint32_t source;
    Numbers at;
    float use;
  };

  /// Makes an empty guide, which changes nothing.
  LightGuide() = default;
  /// `shares`: probabilities of the sources without a guide; their sum is 1. `uses`: the draws that
  /// reached a surface, out of `count` draws; the use of all others is 0.
  LightGuide(std::span<const float> shares, std::span<const Use> uses, uint32_t count);

  bool empty() const { return factor_.empty(); }
  /// Running sums of the probabilities of sources. The guide must not be empty.
  const std::vector<double>& ends() const { return ends_; }
  /// Maps uniform random numbers of a source to the guide's density. Returns the density there, of
  /// source and numbers, relative to that without a guide.
  float warp(uint32_t source, Numbers& at) const;

 private:
  struct Node {
    int axis = -1;       ///< -1 for a leaf
    float value = 0;     ///< probability of the lower half; for a leaf, the density
    uint32_t below = 0;  ///< index of the lower half; the upper half is the next node
  };
  struct Builder;

  std::vector<double> ends_;
  std::vector<float> factor_;    ///< factor of each source's probability
  std::vector<uint32_t> roots_;  ///< root of each source's tree, or kNoTree
  std::vector<Node> nodes_;
  static constexpr uint32_t kNoTree = ~0u;
};

}  // namespace kinome
