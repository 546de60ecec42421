#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kinome/light_groups.h"
#include "kinome/scene.h"
#include "transport/blocks/blocks_of_tile.h"

namespace kinome::transport {

/// Number of values from one light group to the next in columns of radiance: the samples of a
/// block, and one further vector, which FilmSamples may overwrite.
inline constexpr size_t kGroupStride = kBlockSamples + kBlockLanes;

/// Table of a scene's shapes in the order in which stages process hits: by material, so that a BSDF
/// is called once for all points on its surfaces. Shapes that scatter light come first; only they
/// take emitter samples. Perfect mirrors follow, then shapes that only emit. Immutable: created
/// once per render, and shared by all threads.
///
/// Media have rows, too, before those of shapes: a collision in medium k counts as a hit of shape
/// number Scene::shapes().size() + k, whose BSDF is the phase function.
class SceneTable {
 public:
  struct Row {
    const Shape* shape;  ///< nullptr for media
    const Bsdf* bsdf;
    const Emitter* emitter;  ///< nullptr if the shape doesn't emit
    size_t group_offset = 0;  ///< offset of the emitter's light group; see group_offset()
  };

  /// `phases` are the phase functions of the media in which rays may collide; they must outlive the
  /// table. `groups` are the light groups that divide the radiance.
  explicit SceneTable(const Scene& scene, std::span<const Bsdf* const> phases = {},
                      const LightGroups& groups = {});

  const Scene& scene() const { return scene_; }
  const std::vector<Row>& rows() const { return rows_; }
  /// Row of each shape, then of each medium.
  const uint32_t* row_of() const { return row_of_.data(); }
  /// Row of each shape that emits; rows().size() for other shapes.
  const uint32_t* emitting_row_of() const { return emitting_row_of_.data(); }
  /// Row of each shape whose BSDF passes light straight (Lobe::kNull); rows().size() for others.
  const uint32_t* passing_row_of() const { return passing_row_of_.data(); }
  /// True if some BSDF passes light straight.
  bool has_null_lobe() const { return has_null_lobe_; }
  /// Number of rows whose BSDFs have lobes other than kDelta. They are the first rows.
  uint32_t scattering() const { return scattering_; }
  /// Number of rows that reflect light. They are the first rows, and include the scattering ones.
  uint32_t reflecting() const { return reflecting_; }

  /// Number of light groups; 0 if light isn't divided.
  size_t light_groups() const { return light_groups_; }
  /// Index of the first value of the emitter's light group in columns of radiance, for each of
  /// Scene::emitters(): a multiple of kGroupStride. 0 if light isn't divided.
  const uint32_t* group_offsets() const { return group_offsets_.data(); }
  /// The same for the environment.
  size_t environment_offset() const { return environment_offset_; }

 private:
  void set_groups(const LightGroups& groups);

  const Scene& scene_;
  std::vector<Row> rows_;
  /// Indexed like Scene::shapes(), followed by the media.
  std::vector<uint32_t> row_of_, emitting_row_of_, passing_row_of_;
  bool has_null_lobe_ = false;
  uint32_t scattering_ = 0;
  uint32_t reflecting_ = 0;
  size_t light_groups_ = 0;
  std::vector<uint32_t> group_offsets_;
  size_t environment_offset_ = 0;
};

}  // namespace kinome::transport
