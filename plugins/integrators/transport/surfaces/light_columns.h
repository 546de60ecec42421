#pragma once

#include <algorithm>
#include <vector>

#include "transport/blocks/arena.h"
#include "transport/surfaces/scene_table.h"

namespace kinome::transport {

/// Calls fn(columns) for each light group's part of columns of radiance.
template <class Function>
void for_each_group(size_t groups, const Columns3& radiance, const Function& fn) {
  for (size_t g = 0; g < std::max<size_t>(1, groups); ++g) fn(radiance.from(g * kGroupStride));
}

/// Sets the radiance of a block's samples to 0, in all light groups.
inline void clear_radiance(const SceneTable& scene, const Columns3& radiance, size_t samples) {
  for_each_group(scene.light_groups(), radiance, [&](const Columns3& of_group) {
    for (float* const column : {of_group.x, of_group.y, of_group.z}) {
      std::fill_n(column, padded(samples), 0.f);
    }
  });
}

/// Radiance of a block's samples. If the scene's light is divided by group, each column has a part
/// for each group, at SceneTable's offsets. Not thread-safe: use one per thread.
class LightColumns {
 public:
  /// `response`: factor of the groups' values for the film, Film::response().
  LightColumns(const SceneTable& scene, float response)
      : groups_(scene.light_groups()),
        response_(response),
        arena_(std::max<size_t>(1, groups_) * kGroupStride),
        radiance_(arena_.three()),
        total_arena_(kGroupStride),
        total_(groups_ > 0 ? total_arena_.three() : radiance_) {}

  /// Radiance of each group, to which light is added.
  const Columns3& radiance() const { return radiance_; }
  /// Appends the columns of the samples' colour to those of the film.
  void add_color(std::vector<float*>& values) const;
  /// Appends the columns of the groups, in the order of LightGroups::channels().
  void add_groups(std::vector<float*>& values) const;
  /// Sets the colour to the sum of the groups, and then multiplies the groups by the response. Call
  /// it once, before the samples are added to the film.
  void finish(size_t samples) const;

 private:
  size_t groups_;
  float response_;
  Arena arena_;
  Columns3 radiance_;
  Arena total_arena_;
  Columns3 total_;  ///< the same columns as radiance_ if light isn't divided
};

}  // namespace kinome::transport
