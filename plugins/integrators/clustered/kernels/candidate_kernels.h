#pragma once

#include <cstddef>
#include <cstdint>

#include "clustered/kernels/lobe_kernels.h"

/// Kernels over unshadowed directions, whatever points they are at (see lobe_kernels.h for arrays).
namespace kinome::simd {

/// Unshadowed candidates of a group of points: what is known of them, and their weights.
struct WeightColumns {
  const float* f[3];      ///< BSDF x cosine
  const float* radiance;  ///< r, g, b interleaved
  const uint32_t* cell;
  float* weight[3];
  float* uncertainty;  ///< |mean weight| x sigma of the cell
};
/// Of each cell.
struct CellKnowledgeColumns {
  const float* visibility;
  const float* sigma;
};

/// Candidates from a lobe and from cells of distant light.
struct CandidateColumns {
  WeightColumns weights;
  float* cell_density;  ///< of the cell's points; becomes that of the draw from the cells
  const float* lobe_density;
};
struct CandidateQuery {
  const float* importance;  ///< of each cell
  float inverse_total;      ///< of importances; 0: none were drawn from the cells
  float from_cells;         ///< number of candidates drawn so
  float from_lobe;
  float points;  ///< number of points in the group
  CellKnowledgeColumns cells;
};
/// weight = points x f x radiance / (density of both draws); its sum estimates the points' light.
/// control: sum of visibility x weight. Sums of the uncertainties over blocks of kLobeLanes.
void weigh_candidates(const CandidateColumns& candidates, const CandidateQuery& query, size_t count,
                      float control[3], float* block_sums);

/// Candidates that several points share: what is known of each, whatever the point.
struct SharedColumns {
  const float* f[3];        ///< BSDF x cosine at the mean of the points
  const float* radiance;    ///< r, g, b interleaved
  const uint32_t* cell;
  const float* cell_density;  ///< of the cell's points
  const float* lobe_density;
};
template <class Value>
struct SharedValuesOf {
  Value* ratio[3];  ///< radiance / (density of both draws)
  Value* known[3];  ///< visibility x f x ratio
  Value* visibility;
  Value* sigma;
};
using SharedValues = SharedValuesOf<const float>;
/// `query`: of one point, with the numbers of a block. `sums`: of known light over all `count`
/// candidates, three channels.
void share_candidates(const SharedColumns& candidates, const CandidateQuery& query, size_t count,
                      const SharedValuesOf<float>& out, float sums[3]);

/// A block of them at the points that took it.
struct TakenColumns {
  const float* f[3];  ///< BSDF x cosine at these points
  SharedValues shared;
  float* weight[3];
  float* uncertainty;  ///< |mean weight| x sigma
};
/// weight = points x f x ratio; adds visibility x weight - variate x known light to `control`.
struct TakenQuery {
  float points;      ///< that the weights stand for, by the blocks that share them
  float variate[3];
};
void weigh_taken(const TakenColumns& candidates, const TakenQuery& query, size_t count,
                 float control[3], float* block_sums);

/// Candidates toward light points (local_kernels.h), which rays that the surface's own BSDF sends
/// may find as well.
struct ConnectedColumns {
  WeightColumns weights;
  const float* density;    ///< of such a ray, per solid angle
  const float* eye_ratio;  ///< as of ConnectionColumns
};
struct ConnectedQuery {
  float eye_rays;  ///< expected number of such rays
  CellKnowledgeColumns cells;
};
/// The same by weight = f x radiance / (1 + eye_rays x density x eye_ratio): the balance heuristic.
void weigh_connections(const ConnectedColumns& columns, const ConnectedQuery& query, size_t count,
                       float control[3], float* block_sums);

/// A grid over the sphere, as EnvironmentGrid has it; `to_local` is a matrix by rows.
struct SphereGrid {
  float to_local[9];
  int columns, rows;
  float first_column;
};
/// Where unit directions lie on a grid: coordinates x in [0, columns] and y in [0, rows]
/// (interleaved), both within 1e-7 of the grid's size, and the index of the quad.
void find_places(const SphereGrid& grid, const float* dx, const float* dy, const float* dz,
                 size_t count, float* places, uint32_t* quads);

}  // namespace kinome::simd
