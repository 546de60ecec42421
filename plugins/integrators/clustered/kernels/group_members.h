#pragma once

#include <type_traits>

#include "clustered/kernels/lobe_kernels.h"
#include "kinome/wide/textures.h"

// Part of the kernels: values of a group's members. They are computed once, as columns by member;
// each direction then picks its member's values.
namespace kinome::simd {

/// Ways to pick values from a column. If it fits one vector or a few, permutations are faster than
/// gathering.
enum class Picking { kFromOne, kFromFew, kGathered };

template <Picking kPicking>
class GroupMembers {
 public:
  explicit GroupMembers(const PointGroup& group)
      : group_(group), size_(size_of(group.count)), memory_(kMaxColumns, size_) {}

  /// Size of columns: one vector or an even number of vectors. Values behind the last member are
  /// those of the first.
  size_t size() const { return size_; }
  /// Returns memory for one of at most kMaxColumns columns, valid for the lifetime of this object.
  float* column() const { return memory_[columns_++]; }
  /// Indices of the points of members i, i + 1 ...
  KINOME_WIDE wide::Int points(size_t i) const {
    if (i + wide::kLanes <= group_.count) return wide::Int::load(group_.points + i);
    uint32_t points[wide::kLanes];
    for (size_t k = 0; k < wide::kLanes; ++k) {
      points[k] = group_.points[i + k < group_.count ? i + k : 0];
    }
    return wide::Int::load(points);
  }

 private:
  static constexpr size_t kMaxColumns = 16;
  static size_t size_of(size_t count) {
    constexpr size_t two = 2 * wide::kLanes;
    return kPicking == Picking::kFromOne ? wide::kLanes : (count + two - 1) / two * two;
  }
  const PointGroup& group_;
  size_t size_;
  wide::ScratchColumns memory_;
  mutable size_t columns_ = 0;
};

template <Picking kPicking>
class MemberColumn {
 public:
  using Members = GroupMembers<kPicking>;
  /// Gathers the members' values from those of points.
  KINOME_WIDE MemberColumn(const Members& members, const Column<float>& of_points)
      : MemberColumn(members,
                     [&](size_t i) { return gather(of_points.data(), members.points(i)); }) {}
  /// Computes the values by of_members(i), for members i, i + 1 ...
  template <class Function>
  KINOME_WIDE MemberColumn(const Members& members, const Function& of_members)
      : size_(members.size()), values_(members.column()) {
    wide::for_lanes(size_, [&](size_t i) { of_members(i).store(values_ + i); });
  }
  /// Values of members i, i + 1 ...
  KINOME_WIDE wide::Float vector(size_t i) const { return wide::Float::load(values_ + i); }
  /// Values of each direction's member.
  KINOME_WIDE wide::Float operator[](wide::Int member) const {
    if constexpr (kPicking == Picking::kFromOne) {
      return pick(vector(0), member);
    } else if constexpr (kPicking == Picking::kFromFew) {
      constexpr auto two = static_cast<int32_t>(2 * wide::kLanes);
      const wide::Int place = member & (two - 1), first = member - place;
      wide::Float value = pick(vector(0), vector(wide::kLanes), place);
      for (size_t i = two; i < size_; i += two) {
        value = select(first == static_cast<int32_t>(i),
                       pick(vector(i), vector(i + wide::kLanes), place), value);
      }
      return value;
    } else {
      return gather(values_, member);
    }
  }

 private:
  size_t size_;
  float* values_;
};

/// Three columns: vectors of members.
template <Picking kPicking>
class MemberColumns3 {
 public:
  KINOME_WIDE MemberColumns3(const GroupMembers<kPicking>& members,
                             const Column<float> (&of_points)[3])
      : x_(members, of_points[0]), y_(members, of_points[1]), z_(members, of_points[2]) {}
  KINOME_WIDE wide::Vec3 vector(size_t i) const {
    return {x_.vector(i), y_.vector(i), z_.vector(i)};
  }
  KINOME_WIDE wide::Vec3 operator[](wide::Int member) const {
    return {x_[member], y_[member], z_[member]};
  }

 private:
  MemberColumn<kPicking> x_, y_, z_;
};

/// Calls fn(GroupMembers) with the fastest way of picking for this group.
template <class Function>
void with_members(const PointGroup& group, const Function& fn) {
  constexpr size_t kFewVectors = 8;
  if (group.count <= wide::kLanes) return fn(GroupMembers<Picking::kFromOne>(group));
  if (group.count <= kFewVectors * wide::kLanes) {
    return fn(GroupMembers<Picking::kFromFew>(group));
  }
  fn(GroupMembers<Picking::kGathered>(group));
}

}  // namespace kinome::simd
