#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kinome/scene.h"

namespace kinome::transport {

/// The shapes of a scene in the order in which stages process hits: by material, so that a BSDF is
/// called once for all points on its surfaces. Shapes that scatter light come first; only these
/// take emitter samples. Perfect mirrors follow, then shapes that only emit. Immutable: made once
/// per render, shared by all threads.
///
/// Media are rows, too, before those of shapes: a collision in medium k is a hit of shape number
/// Scene::shapes().size() + k, and the phase function is its BSDF.
class SceneTable {
 public:
  struct Row {
    const Shape* shape;  ///< nullptr for media
    const Bsdf* bsdf;
    const Emitter* emitter;  ///< nullptr if the shape doesn't emit
  };

  /// `phases`: phase functions of the media in which rays may collide; they must outlive the table.
  explicit SceneTable(const Scene& scene, std::span<const Bsdf* const> phases = {});

  const Scene& scene() const { return scene_; }
  const std::vector<Row>& rows() const { return rows_; }
  /// Row of each shape, then of each medium.
  const uint32_t* row_of() const { return row_of_.data(); }
  /// Row of each shape that emits; rows().size() for other shapes.
  const uint32_t* emitting_row_of() const { return emitting_row_of_.data(); }
  /// Row of each shape whose BSDF passes light straight (Lobe::kNull); rows().size() for others.
  const uint32_t* passing_row_of() const { return passing_row_of_.data(); }
  /// True if some BSDF passes light straight.
  bool passes_straight() const { return passes_straight_; }
  /// Rows before this one scatter light: their BSDFs have lobes other than kDelta.
  uint32_t scattering() const { return scattering_; }
  /// Rows before this one reflect.
  uint32_t reflecting() const { return reflecting_; }

 private:
  const Scene& scene_;
  std::vector<Row> rows_;
  /// Indexed like Scene::shapes(), followed by the media.
  std::vector<uint32_t> row_of_, emitting_row_of_, passing_row_of_;
  bool passes_straight_ = false;
  uint32_t scattering_ = 0;
  uint32_t reflecting_ = 0;
};

}  // namespace kinome::transport
