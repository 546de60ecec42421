#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/product/patches.h"
#include "clustered/product/spread.h"

namespace kinome {

/// Points of a unit that share strata: of one patch and, where its lobe is sharp, of nearly one
/// normal.
struct Group {
  int32_t patch = 0;
  uint32_t first = 0;  ///< of Groups::order
  uint32_t count = 0;
  Vec3 normal{0.f};       ///< mean, unit
  Vec3 viewer{0.f};       ///< mean, unit
  float cosine = 1;       ///< of the cone around `normal` that holds all normals
  Vec3 albedo_normal[3];  ///< sum of diffuse reflectance x normal, of each channel
  float albedo = 0;       ///< sum of the mean reflectance
  Rgb reflectance{0.f};   ///< sum of diffuse reflectance
};

/// Divides primaries of a tile into groups. Keeps its memory: one per thread.
class Groups {
 public:
  /// Primaries [first, end), without those that reflect nothing (TilePrimaries::patch).
  void divide(const TilePrimaries& primaries, std::span<const Patch> patches, uint32_t first,
              uint32_t end);

  bool empty() const { return groups_.empty(); }
  uint32_t size() const { return static_cast<uint32_t>(groups_.size()); }
  const Group& operator[](size_t i) const { return groups_[i]; }
  /// The primaries, group by group; within a group they go up.
  std::span<const uint32_t> order() const { return order_; }
  const uint32_t* members(const Group& group) const { return &order_[group.first]; }
  /// Of the same, their points among those of Primaries.
  const uint32_t* points(const Group& group) const { return &points_[group.first]; }

 private:
  int32_t group_for(uint32_t primary, const TilePrimaries& primaries,
                    std::span<const Patch> patches);
  void add(uint32_t primary, const TilePrimaries& primaries, std::span<const Patch> patches);

  std::vector<Group> groups_;
  std::vector<int32_t> group_of_;  ///< of each primary, from the first on
  std::vector<uint32_t> order_, points_;
  std::vector<int32_t> first_group_;  ///< of each patch
};

/// A group as stages take it: its points, with their patch and what is known of visibility there.
/// A member is a number below group.count, a primary its number in the tile.
struct GroupView {
  const Group& group;
  uint32_t index;  ///< in Groups
  const Patch& patch;
  const Visibility& visibility;
  const TilePrimaries& primaries;
  const uint32_t* members;    ///< their primaries
  const uint32_t* point_ids;  ///< the points of these, among those of Primaries

  bool has(Lobe lobes) const { return any(patch.bsdf->lobes() & lobes); }
  uint32_t primary(uint32_t member) const { return members[member]; }
  SurfaceInteraction interaction(uint32_t member) const {
    return primaries.interaction(members[member]);
  }
  /// See TilePrimaries::place.
  SurfaceInteraction place(uint32_t member) const { return primaries.place(members[member]); }
  Frame frame(uint32_t member) const { return primaries.frame(members[member]); }
  Vec3 normal(uint32_t member) const { return primaries.normal(members[member]); }
  /// The member at a share of all, in units of 2^-32.
  uint32_t pick(uint32_t share) const { return scaled(share, group.count); }
  simd::PointGroup points() const { return {primaries.frames(), point_ids, group.count}; }
};

}  // namespace kinome
