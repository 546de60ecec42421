#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/product/tiles/patches.h"
#include "clustered/product/tiles/unit.h"

namespace kinome {

/// Points of one patch of a tile that reflect nearly alike: half vectors of the lobe are about the
/// same for all of them.
struct PointNode {
  int32_t patch = 0;
  uint32_t pixels = 0;  ///< number of pixels with points in the node
  uint32_t points = 0;
  double wanted = 0;              ///< number of candidates that these pixels want
  Vec3 normal{0.f}, viewer{0.f};  ///< means, unit
  Vec3 tangent{0.f};              ///< unit, orthogonal to the normal
  float cosine = 1;               ///< of the cone around `normal` that contains all normals
  float spread2 = 0;              ///< mean square of offset() over the points

  /// Offset of a point's half vectors from those of the mean point, as a slope. If the normal turns
  /// by half of what the viewer turns, a direction of light is equally far from both mirror
  /// directions, and the offset is 0.
  Vec3 offset(const Vec3& of_normal, const Vec3& of_viewer) const {
    const Vec3 turned = (of_normal - normal) - 0.5f * (of_viewer - viewer);
    return turned - normal * glm::dot(turned, normal);
  }
};

/// Divides the points of a tile's units into nodes. Reuses its memory; one object per thread.
class PointNodes {
 public:
  /// Divides the points whose form is described and has a microfacet lobe. `patches` must outlive
  /// later calls.
  void divide(const TilePrimaries& primaries, std::span<const Patch> patches,
              std::span<const Unit> units);
  void clear() {
    nodes_.clear();
    node_of_.clear();
  }

  std::span<const PointNode> nodes() const { return nodes_; }
  /// Index of a primary's node, or -1.
  int32_t of(uint32_t primary) const {
    return primary < node_of_.size() ? node_of_[primary] : -1;
  }

 private:
  /// Sums over points.
  struct Sums {
    uint32_t points = 0;
    glm::dvec3 normal{0.}, viewer{0.}, half{0.};
    double half2 = 0;
    static Sums of(const glm::dvec3& n, const glm::dvec3& w);
    void add(const Sums& other);
    glm::dvec3 mean_half() const { return half / static_cast<double>(points); }
  };
  /// A pixel's points of one patch, which belong to one node.
  struct Part {
    int32_t patch;
    float wanted;
    int32_t node;
    Sums sums;
  };
  void find_parts(const TilePrimaries& primaries, std::span<const Patch> patches,
                  const Unit& unit);
  int32_t node_for(const Part& part, float alpha2);
  void finish(const TilePrimaries& primaries, std::span<const Patch> patches);

  std::vector<PointNode> nodes_;
  std::vector<Sums> sums_;        ///< of each node
  std::vector<Part> parts_;
  std::vector<int32_t> part_of_patch_;  ///< part of each patch, for the current unit
  std::vector<int32_t> node_of_;        ///< node of each primary; its part until finish()
};

}  // namespace kinome
