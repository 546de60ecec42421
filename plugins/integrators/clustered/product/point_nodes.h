#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/product/patches.h"
#include "clustered/product/unit.h"

namespace kinome {

/// Points of a tile that reflect nearly alike: they belong to one patch, and half vectors of its
/// lobe are about the same for all of them.
struct PointNode {
  int32_t patch = 0;
  uint32_t pixels = 0;            ///< that have points here
  uint32_t points = 0;
  double wanted = 0;              ///< candidates of all these pixels
  Vec3 normal{0.f}, viewer{0.f};  ///< means, unit
  Vec3 tangent{0.f};              ///< unit, orthogonal to the normal
  float cosine = 1;               ///< of the cone around `normal` that holds all normals
  float spread2 = 0;              ///< mean square of offset() of the points

  /// How far the half vectors of a point are from those of the mean one, as a slope: a direction of
  /// light is as far from the point's mirror direction as it is from the mean one's where the normal
  /// has turned by half of what the viewer has.
  Vec3 offset(const Vec3& of_normal, const Vec3& of_viewer) const {
    const Vec3 turned = (of_normal - normal) - 0.5f * (of_viewer - viewer);
    return turned - normal * glm::dot(turned, normal);
  }
};

/// Divides the points of a tile's units into nodes. Keeps its memory: one per thread.
class PointNodes {
 public:
  /// Those of microfacet lobes that are described; `patches` must outlive the next calls.
  void divide(const TilePrimaries& primaries, std::span<const Patch> patches,
              std::span<const Unit> units);
  void clear() {
    nodes_.clear();
    node_of_.clear();
  }

  std::span<const PointNode> nodes() const { return nodes_; }
  /// Of a primary; -1: none.
  int32_t of(uint32_t primary) const {
    return primary < node_of_.size() ? node_of_[primary] : -1;
  }

 private:
  /// Sums over points.
  struct Sums {
    uint32_t points = 0;
    glm::dvec3 normal{0.}, viewer{0.}, half{0.};
    double half2 = 0;
    void add(const Vec3& n, const Vec3& w);
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
  std::vector<int32_t> part_of_patch_;  ///< of the unit at work
  std::vector<int32_t> node_of_;        ///< of each primary; at first, its part
};

}  // namespace kinome
