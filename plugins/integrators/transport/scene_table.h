#pragma once

#include <cstdint>
#include <vector>

#include "kinome/scene.h"

namespace kinome::transport {

/// The shapes of a scene in the order in which stages go through what was hit: by material, so that
/// a BSDF is asked once for all points on its surfaces. First those that scatter, to which emitters
/// may be sampled, then perfect mirrors, then those that only emit. Immutable: made once a render,
/// shared by all threads.
class SceneTable {
 public:
  struct Row {
    const Shape* shape;
    const Bsdf* bsdf;
    const Emitter* emitter;  ///< nullptr: it doesn't emit
  };

  explicit SceneTable(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const std::vector<Row>& rows() const { return rows_; }
  /// The row of each shape.
  const uint32_t* row_of() const { return row_of_.data(); }
  /// The same for shapes that emit; for the others no row, but rows().size().
  const uint32_t* emitting_row_of() const { return emitting_row_of_.data(); }
  /// The same for shapes whose BSDFs pass light straight (Lobe::kNull).
  const uint32_t* passing_row_of() const { return passing_row_of_.data(); }
  /// True if some BSDF passes light straight.
  bool passes_straight() const { return passes_straight_; }
  /// Rows before this one scatter light: they have other lobes than kDelta.
  uint32_t scattering() const { return scattering_; }
  /// Rows before this one reflect.
  uint32_t reflecting() const { return reflecting_; }

 private:
  const Scene& scene_;
  std::vector<Row> rows_;
  /// Of indices into Scene::shapes().
  std::vector<uint32_t> row_of_, emitting_row_of_, passing_row_of_;
  bool passes_straight_ = false;
  uint32_t scattering_ = 0;
  uint32_t reflecting_ = 0;
};

}  // namespace kinome::transport
