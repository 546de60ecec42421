#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/product/tiles/patches.h"
#include "clustered/product/tiles/spread.h"

namespace kinome {

/// Points of a unit that share strata. They belong to one patch, and have nearly one normal if the
/// patch's lobe is sharp.
struct Group {
  int32_t patch = 0;
  uint32_t first = 0;  ///< index in Groups::order()
  uint32_t count = 0;
  Vec3 normal{0.f};       ///< mean, unit
  Vec3 viewer{0.f};       ///< mean, unit
  float cosine = 1;       ///< of the cone around `normal` that contains all normals
  Vec3 albedo_normal[3];  ///< sum of diffuse reflectance x normal, for each channel
  float albedo = 0;       ///< sum of the mean reflectance
  Rgb reflectance{0.f};   ///< sum of diffuse reflectance
};

struct GroupView;

/// Divides primaries of a tile into groups. Reuses its memory; one per thread.
class Groups {
 public:
  /// Divides primaries [first, end), without those that reflect nothing (TilePrimaries::patch).
  void divide(const TilePrimaries& primaries, std::span<const Patch> patches, uint32_t first,
              uint32_t end);

  bool empty() const { return groups_.empty(); }
  uint32_t size() const { return static_cast<uint32_t>(groups_.size()); }
  const Group& operator[](size_t i) const { return groups_[i]; }
  /// The primaries, group by group, in ascending order within a group.
  std::span<const uint32_t> order() const { return order_; }
  const uint32_t* members(const Group& group) const { return &order_[group.first]; }
  /// Returns a group as input of the stages. The arguments are those of the tile.
  GroupView view(uint32_t index, std::span<const Patch> patches,
                 std::span<const Visibility> visibility, const TilePrimaries& primaries) const;

 private:
  int32_t group_for(uint32_t primary, const TilePrimaries& primaries,
                    std::span<const Patch> patches);
  void add(uint32_t primary, const TilePrimaries& primaries, std::span<const Patch> patches);

  std::vector<Group> groups_;
  std::vector<int32_t> group_of_;  ///< for each primary, from the first on
  std::vector<uint32_t> order_, points_;
  std::vector<int32_t> first_group_;  ///< for each patch
};

/// Input of the stages: a group's points with their patch and its learned visibility. A member is
/// an index below group.count; a primary is an index in the tile.
struct GroupView {
  const Group& group;
  uint32_t index;  ///< index in Groups
  const Patch& patch;
  const Visibility& visibility;
  const TilePrimaries& primaries;
  const uint32_t* members;    ///< primary of each member
  const uint32_t* point_ids;  ///< index of each member's point in Primaries

  bool has(Lobe lobes) const { return any(patch.bsdf->lobes() & lobes); }
  uint32_t primary(uint32_t member) const { return members[member]; }
  SurfaceInteraction interaction(uint32_t member) const {
    return primaries.interaction(members[member]);
  }
  /// See TilePrimaries::place.
  SurfaceInteraction place(uint32_t member) const { return primaries.place(members[member]); }
  Frame frame(uint32_t member) const { return primaries.frame(members[member]); }
  Vec3 normal(uint32_t member) const { return primaries.normal(members[member]); }
  /// Returns the member at the fraction `share` of the group, in units of 2^-32.
  uint32_t pick(uint32_t share) const { return scaled(share, group.count); }
  simd::PointGroup points() const { return {primaries.frames(), point_ids, group.count}; }
};

inline GroupView Groups::view(uint32_t index, std::span<const Patch> patches,
                              std::span<const Visibility> visibility,
                              const TilePrimaries& primaries) const {
  const Group& group = groups_[index];
  return {group,
          index,
          patches[group.patch],
          visibility[group.patch],
          primaries,
          &order_[group.first],
          &points_[group.first]};
}

}  // namespace kinome
