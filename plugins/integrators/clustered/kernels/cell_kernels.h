#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kinome/columns.h"

/// Kernels over the cells of distant light. Arrays are padded to kCellLanes values; those of the
/// padding are zero.
namespace kinome::simd {

inline constexpr size_t kCellLanes = kBlockLanes;

/// See DistantCells for what these are.
struct CellColumns {
  size_t count = 0;  ///< padded
  const float* edges[8];
  const float* axis[3];
  const float* radius;
  const float* flux;
  const float* importance_flux[3];
  const float* vector_flux[9];
};

/// The cells as a patch of surface sees them: those wholly above the horizon of each of its
/// normals (`above`), and those that may straddle one (`mixed`); the rest is below all of them.
/// What depends on a normal is linear in it for the former, so that all of their control terms are
/// nine sums. Buffers are kept from patch to patch.
class PatchCells {
 public:
  void reserve(size_t padded_cells);

  size_t above = 0;  ///< padded; cells are ids()[0, above)
  size_t mixed = 0;  ///< padded; cells are ids()[above, above + mixed)
  /// Sum over the cells above of visibility x vector flux [channel x 3 + axis].
  float control[9] = {};

  const uint32_t* ids() const { return ids_.data(); }
  uint32_t* ids() { return ids_.data(); }
  /// Of the cells above: sigma x importance flux (x, y, z), and the least that counts.
  enum Above { kSigmaX, kSigmaY, kSigmaZ, kLeast, kAboveColumns };
  /// Of mixed cells: the edges, importance flux, flux, sigma where the cell turns out above and
  /// where it straddles, visibility, visibility x vector flux.
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
    /// Where is_flat: visibility x light that the patch's mean normal reflects of the part of the
    /// cell above its horizon (three channels), and sigma x the mean of these.
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

/// What is learned of the light of each cell at a patch.
struct CellKnowledge {
  const float* visibility;   ///< v: used in control terms
  const float* sigma;        ///< standard deviation left, v being given
  const float* sigma_mixed;  ///< the same where v is taken as 0
};

/// Sorts the cells for a patch of normals within an angle of `sine` around `local_normal` (in the
/// cells' own space). `blocks`: those that aren't wholly below its horizon, kCellLanes cells each.
/// Visibility multiplies `transmittance`, a factor of the diffuse reflection for each cell
/// (nullptr: 1), in control and sigma.
void classify_cells(const CellColumns& cells, std::span<const uint32_t> blocks,
                    const float local_normal[3], float sine, const CellKnowledge& knowledge,
                    const float* transmittance, PatchCells& patch);

/// Normals of a group of points: their mean, and the sine of the cone around it that holds them.
struct GroupNormal {
  float world[3];
  float local[3];
  float sine;
};

/// Standard deviation of the unknown part of each cell's diffuse light at a group of points, times
/// `scale`: what shadow rays are distributed by, in `p` (above + mixed values), with the sums of
/// each kCellLanes of them in `block_sums`. mixed_visibility (mixed values) receives the visibility
/// that the control of a mixed cell has at this group: v where it is above the horizon, -v where it
/// straddles that of a flat patch, else 0. control: patch.control and the mixed cells' part.
/// straddling: sum over the cells with -v of kStraddling. Returns the sum of all.
float diffuse_strata(const PatchCells& patch, const GroupNormal& normal, float scale, float* p,
                     float* block_sums, float* mixed_visibility, float control[9],
                     float straddling[3]);

/// Importance of each cell for a glossy lobe around the mirror direction, as of GGX with the
/// squared roughness `alpha2` widened by each cell's extent: flux x lobe, 0 below the horizon of
/// all normals in the cone. Returns the sum; block_sums as above.
struct GlossyQuery {
  float normal[3];
  float viewer[3];  ///< unit, toward the viewer
  float alpha2;
  float spread;  ///< 1 - cosine of the cone of normals
};
float glossy_importance(const CellColumns& cells, const GlossyQuery& query, float* importance,
                        float* block_sums);

/// Sums of each kCellLanes of `count` (padded) values; returns the sum of all.
float sum_blocks(const float* values, size_t count, float* block_sums);

}  // namespace kinome::simd
