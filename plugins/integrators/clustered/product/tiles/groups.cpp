#include "clustered/product/tiles/groups.h"

#include <algorithm>

namespace kinome {
namespace {

/// Normals of a group with a sharp lobe are within 1 - cos < kSharpSpread alpha² of their mean.
constexpr float kSharpSpread = 0.5f;
constexpr size_t kMaxGroups = 64;

}  // namespace

/// Returns the group to which the primary belongs, or -1 if a new group is needed.
int32_t Groups::group_for(uint32_t primary, const TilePrimaries& primaries,
                          std::span<const Patch> patches) {
  const int32_t patch = primaries.patch(primary);
  int32_t group = first_group_[patch];
  if (group < 0 || !is_sharp(patches[patch])) return group;
  const Vec3 n = primaries.normal(primary);
  float best = -2;
  for (size_t k = 0; k < groups_.size(); ++k) {
    if (groups_[k].patch != patch) continue;
    const float cosine = glm::dot(normalized(groups_[k].normal, n), n);
    if (cosine <= best) continue;
    best = cosine;
    group = static_cast<int32_t>(k);
  }
  const bool fits = best > 1 - kSharpSpread * patches[patch].alpha2();
  return fits || groups_.size() >= kMaxGroups ? group : -1;
}

/// Adds a primary to its group. Mean normal and viewer are sums until divide() normalises them.
void Groups::add(uint32_t primary, const TilePrimaries& primaries, std::span<const Patch> patches) {
  const int32_t patch = primaries.patch(primary);
  int32_t group = group_for(primary, primaries, patches);
  if (group < 0) {
    group = static_cast<int32_t>(groups_.size());
    if (first_group_[patch] < 0) first_group_[patch] = group;
    groups_.push_back({});
    groups_.back().patch = patch;
  }
  group_of_.push_back(group);
  Group& g = groups_[group];
  const Vec3 n = primaries.normal(primary);
  const Rgb albedo = primaries.diffuse(primary);
  ++g.count;
  g.normal += n;
  g.viewer += primaries.viewer(primary);
  for (int c = 0; c < 3; ++c) g.albedo_normal[c] += albedo[c] * n;
  g.albedo += mean_of(albedo);
  g.reflectance += albedo;
}

void Groups::divide(const TilePrimaries& primaries, std::span<const Patch> patches, uint32_t first,
                    uint32_t end) {
  groups_.clear();
  group_of_.clear();
  first_group_.assign(patches.size(), -1);
  for (uint32_t i = first; i < end; ++i) {
    if (primaries.patch(i) < 0) {
      group_of_.push_back(-1);
    } else {
      add(i, primaries, patches);
    }
  }
  uint32_t next = 0;
  for (Group& group : groups_) {
    group.first = next;
    next += group.count;
    group.count = 0;
    const Patch& patch = patches[group.patch];
    group.normal = normalized(group.normal, patch.normal);
    group.viewer = normalized(group.viewer, patch.viewer);
  }
  order_.resize(next);
  points_.resize(next);
  for (uint32_t i = first; i < end; ++i) {
    const int32_t k = group_of_[i - first];
    if (k < 0) continue;
    Group& group = groups_[k];
    points_[group.first + group.count] = static_cast<uint32_t>(primaries.point(i));
    order_[group.first + group.count++] = i;
    group.cosine = std::min(group.cosine, glm::dot(group.normal, primaries.normal(i)));
  }
}

}  // namespace kinome
