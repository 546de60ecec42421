#pragma once

#include "clustered/cells/light_cells.h"
#include "clustered/kernels/cell_kernels.h"
#include "clustered/product/local_light.h"

namespace kinome {

class Caustics;

/// Light of one pass: its cells and the points drawn of them. Cells of distant light are numbered
/// first, those of local light from first_local() on. Immutable; thread-safe. What it is made of
/// must outlive it.
struct CellLight {
  /// Points that do for so many rays: fewer would be noise that rays share. The most fit a core's
  /// own cache, and more do no better.
  static uint32_t points_for(double rays);
  const DistantCells& cells;
  const Emitter* environment;  ///< nullptr: there is none
  CellPoints points;
  const LocalLight* local;  ///< nullptr: there is none
  LocalPoints local_points;
  simd::CellColumns columns;
  const Caustics* caustics = nullptr;  ///< that have a share in what chains of mirrors show
  /// Whether cells at the horizon of a flat surface have control terms.
  bool horizon_terms = true;
  PathSettings paths{{2, 5}, false};  ///< of those that are followed from the camera on
  /// The scene, if it has surfaces that light passes straight; nullptr: it has none.
  const transport::SceneTable* passing() const { return local ? local->passing() : nullptr; }
  CellLight(const DistantCells& cells, const Emitter* environment, CellPoints points,
            const LocalLight* local = nullptr, LocalPoints local_points = {});
  uint32_t first_local() const { return cells.padded_size(); }
  bool has_distant() const { return columns.count > 0; }
};

}  // namespace kinome
