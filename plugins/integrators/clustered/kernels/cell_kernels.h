#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kinome/columns.h"

/// Kernels over the cells of distant light. Arrays are padded to kCellLanes values; the padding is
/// zero.
namespace kinome::simd {

inline constexpr size_t kCellLanes = kBlockLanes;

/// Columns of DistantCells, which defines their meaning.
struct CellColumns {
  size_t count = 0;  ///< padded
  const float* edges[8];
  const float* axis[3];
  const float* radius;
  const float* flux;
  const float* importance_flux[3];
  const float* vector_flux[9];
};

/// The cells as seen from a patch: those wholly above the horizon of each of its normals (`above`),
/// and those that may straddle one (`mixed`). The others are below all of them. Light of cells
/// above is linear in the normal, so that all of their control terms are nine sums. Buffers are
/// reused from patch to patch.
class PatchCells {
 public:
  void reserve(size_t padded_cells);

  size_t above = 0;  ///< padded; cells are ids()[0, above)
  size_t mixed = 0;  ///< padded; cells are ids()[above, above + mixed)
  /// Sum over the cells above of visibility x vector flux [channel x 3 + axis].
  float control[9] = {};

  const uint32_t* ids() const { return ids_.data(); }
  uint32_t* ids() { return ids_.data(); }
  /// Columns of cells above: sigma x importance flux (x, y, z), and the minimum of their stratum.
  enum Above { kSigmaX, kSigmaY, kSigmaZ, kMinFlux, kAboveColumns };
  /// Columns of mixed cells: edges, importance flux, flux, sigma if the cell is above a group's
  /// horizon, sigma if it straddles it, visibility, visibility x vector flux.
  enum Mixed {
    kEdges = 0,
    kFluxX = 8,
    kFluxY,
    kFluxZ,
    kFlux,
    kSigma,
    kSigmaMixed,
    kVisibility,
    kControl,
    /// If is_flat: visibility x light that the patch's mean normal reflects from the part of the
    /// cell above its horizon (three channels), and sigma x the mean of these channels.
    kStraddling = kControl + 9,
    kStraddlingSigma = kStraddling + 3,
    kMixedColumns
  };
  bool is_flat = false;  ///< cells at the horizon have control terms, too
  float* above_column(int i) { return above_.data() + i * stride_; }
  const float* above_column(int i) const { return above_.data() + i * stride_; }
  float* mixed_column(int i) { return mixed_.data() + i * stride_; }
  const float* mixed_column(int i) const { return mixed_.data() + i * stride_; }

 private:
  size_t stride_ = 0;
  std::vector<float> above_, mixed_;
  std::vector<uint32_t> ids_;
};

/// Learned visibility of each cell at a patch.
struct CellKnowledge {
  const float* visibility;   ///< v: used in control terms
  const float* sigma;        ///< standard deviation that remains, given v
  const float* sigma_mixed;  ///< the same if v is taken as 0
};

/// Classifies the cells for a patch whose normals are within a cone of half angle asin(sine) around
/// `local_normal` (in the cells' local space). `blocks`: blocks of kCellLanes cells that aren't
/// wholly below its horizon. In control terms and sigma, visibility is multiplied by
/// `transmittance`, a factor of the diffuse reflection for each cell (nullptr: 1).
void classify_cells(const CellColumns& cells, std::span<const uint32_t> blocks,
                    const float local_normal[3], float sine, const CellKnowledge& knowledge,
                    const float* transmittance, PatchCells& patch);

/// Normals of a group of points: their mean, and the sine of the half angle of a cone around it
/// that contains them.
struct GroupNormal {
  float world[3];
  float local[3];
  float sine;
};

/// Computes the strata of shadow rays at a group of points: the standard deviation of the unknown
/// part of each cell's diffuse light, times `scale`. Writes them to `p` (above + mixed values), and
/// the sums of each kCellLanes of them to `block_sums`. Returns the sum of all.
///
/// mixed_visibility (mixed values) receives the visibility in a mixed cell's control term at this
/// group: v if the cell is above the horizon, -v if it straddles the horizon of a flat patch, else
/// 0. control: patch.control plus the terms of mixed cells. straddling: sum of kStraddling over the
/// cells with -v.
float diffuse_strata(const PatchCells& patch, const GroupNormal& normal, float scale, float* p,
                     float* block_sums, float* mixed_visibility, float control[9],
                     float straddling[3]);

struct GlossyQuery {
  float normal[3];
  float viewer[3];  ///< unit, toward the viewer
  float alpha2;
  float spread;  ///< 1 - cosine of the half angle of the cone of normals
};
/// Computes the importance of each cell for a glossy lobe around the mirror direction: flux x lobe,
/// or 0 below the horizon of all normals in the cone. The lobe is that of GGX with the squared
/// roughness `alpha2`, widened by each cell's extent. Returns the sum; block_sums as above.
float glossy_importance(const CellColumns& cells, const GlossyQuery& query, float* importance,
                        float* block_sums);

}  // namespace kinome::simd
