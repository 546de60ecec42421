#pragma once

#include <cstddef>
#include <cstdint>

#include "clustered/kernels/lobe_kernels.h"

/// Kernels over candidates of all kinds: directions and connections whose unoccluded light is
/// known. See lobe_kernels.h for the padding of arrays.
namespace kinome::simd {

/// Candidates of a group of points, and their weights.
struct WeightColumns {
  const float* f[3];      ///< BSDF x cosine
  const float* radiance;  ///< r, g, b interleaved
  const uint32_t* cell;
  float* weight[3];
  float* uncertainty;  ///< |mean weight| x sigma of the cell
};
/// Learned visibility of each cell.
struct CellKnowledgeColumns {
  const float* visibility;
  const float* sigma;
};

/// Candidates from a lobe and from cells of distant light.
struct CandidateColumns {
  WeightColumns weights;
  float* cell_density;  ///< density of the cell's points; becomes that of draws from all cells
  const float* lobe_density;
};
struct CandidateQuery {
  const float* importance;  ///< importance of each cell
  float inverse_total;      ///< 1 / sum of the importances; 0 if none were drawn from the cells
  float from_cells;         ///< number of candidates drawn from the cells
  float from_lobe;          ///< number of candidates drawn from the lobe
  float points;  ///< number of points in the group
  CellKnowledgeColumns cells;
};
/// Sets weight = points x f x radiance / (density of both draws). The sum of the weights estimates
/// the points' light. control: sum of visibility x weight. block_sums: sums of the uncertainties of
/// each kLobeLanes candidates.
void weigh_candidates(const CandidateColumns& candidates, const CandidateQuery& query, size_t count,
                      float control[3], float* block_sums);

/// Candidates that several points share: values that don't depend on the point.
struct SharedColumns {
  const float* f[3];        ///< BSDF x cosine at the mean of the points
  const float* radiance;    ///< r, g, b interleaved
  const uint32_t* cell;
  const float* cell_density;  ///< density of the cell's points
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
/// `query`: for one point, with the numbers of candidates in a block. `sums`: sum of the known
/// light over all `count` candidates, three channels.
void share_candidates(const SharedColumns& candidates, const CandidateQuery& query, size_t count,
                      const SharedValuesOf<float>& out, float sums[3]);

/// A block of shared candidates at the points that took it.
struct TakenColumns {
  const float* f[3];  ///< BSDF x cosine at these points
  SharedValues shared;
  float* weight[3];
  float* uncertainty;  ///< |mean weight| x sigma
};
struct TakenQuery {
  float points;  ///< number of points that the weights represent / number of blocks they took
  float variate[3];
};
/// Sets weight = points x f x ratio; adds visibility x weight - variate x known light to `control`.
void weigh_taken(const TakenColumns& candidates, const TakenQuery& query, size_t count,
                 float control[3], float* block_sums);

/// Connections to light points (local_kernels.h). Eye rays, which the surface's BSDF samples, may
/// find the same light.
struct ConnectedColumns {
  WeightColumns weights;
  const float* density;    ///< density of an eye ray, per solid angle
  const float* eye_ratio;  ///< see ConnectionColumns
};
struct ConnectedQuery {
  float eye_rays;  ///< expected number of eye rays
  CellKnowledgeColumns cells;
};
/// The same with the balance heuristic: weight = f x radiance / (1 + eye_rays x density x
/// eye_ratio).
void weigh_connections(const ConnectedColumns& columns, const ConnectedQuery& query, size_t count,
                       float control[3], float* block_sums);

/// A grid over the sphere, like EnvironmentGrid; `to_local` is a row-major matrix.
struct SphereGrid {
  float to_local[9];
  int columns, rows;
  float first_column;
};
/// Computes the positions of unit directions on a grid: coordinates x in [0, columns] and y in
/// [0, rows] (interleaved), with errors within 1e-7 of the grid's size, and the index of the quad.
void find_places(const SphereGrid& grid, const float* dx, const float* dy, const float* dz,
                 size_t count, float* places, uint32_t* quads);

}  // namespace kinome::simd
