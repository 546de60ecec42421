#include "clustered/kernels/candidate_kernels.h"

#include "clustered/kernels/lobe_kernels.h"
#include "clustered/kernels/vector_columns.h"
#include "kinome/wide/functions.h"

namespace kinome::simd {
namespace {

using wide::Float;
using wide::Int;
using wide::kLanes;
using wide::Vec2;
using wide::Vec3;

KINOME_WIDE void store(const Vec3& value, float* const columns[3], size_t i) {
  value.store({columns[0], columns[1], columns[2]}, i);
}

/// Weights of one vector of candidates.
struct Weighed {
  Vec3 weight;
  Float sigma;
};
/// Stores weights and uncertainties of candidates. values(i, sums) returns those of the vector that
/// begins at i, and adds its control terms to `sums`.
template <class Values>
void weigh(float* const weight[3], float* uncertainty, size_t count, float control[3],
           float* block_sums, const Values& values) {
  Vec3 sums(0.f);
  for (size_t block = 0; block < count / kLobeLanes; ++block) {
    Float block_sum = 0.f;
    for (size_t i = block * kLobeLanes; i < (block + 1) * kLobeLanes; i += kLanes) {
      const Weighed of = values(i, sums);
      store(of.weight, weight, i);
      const Float mean = (of.weight.x + of.weight.y + of.weight.z) * (1 / 3.f);
      const Float uncertain = abs(mean) * of.sigma;
      uncertain.store(uncertainty + i);
      block_sum += uncertain;
    }
    block_sums[block] = sum(block_sum);
  }
  for (int k = 0; k < 3; ++k) control[k] += sum(sums[k]);
}

/// Sets weight = f x radiance x factor(first candidate of a vector, their cells), and adds control
/// terms.
template <class Factor>
void weigh_by(const WeightColumns& c, const CellKnowledgeColumns& cells, size_t count,
              float control[3], float* block_sums, const Factor& factor) {
  for (int k = 0; k < 3; ++k) control[k] = 0;
  weigh(c.weight, c.uncertainty, count, control, block_sums, [&](size_t i, Vec3& sums) {
    const Int cell = Int::load(c.cell + i);
    const Vec3 weight = load(c.f, i) * Vec3::load_interleaved(c.radiance + 3 * i) * factor(i, cell);
    sums = mul_add(gather(cells.visibility, cell), weight, sums);
    return Weighed{weight, gather(cells.sigma, cell)};
  });
}

/// Returns the query's number of points / density of both draws, for a vector of candidates.
/// `from_cell`: density of draws from the cells.
KINOME_WIDE Float points_over_density(const CandidateQuery& query, Float from_cell, Float from_lobe) {
  const Float density = query.from_cells * from_cell + query.from_lobe * from_lobe;
  return select(density > 0.f, query.points / max(density, 1e-37f));
}
KINOME_WIDE Float density_from_cells(const CandidateQuery& query, Float of_points, Int cell) {
  return of_points * (gather(query.importance, cell) * query.inverse_total);
}

}  // namespace

void weigh_candidates(const CandidateColumns& candidates, const CandidateQuery& query, size_t count,
                      float control[3], float* block_sums) {
  weigh_by(candidates.weights, query.cells, count, control, block_sums, [&](size_t i, Int cell) {
    const Float from_cell =
        density_from_cells(query, Float::load(candidates.cell_density + i), cell);
    from_cell.store(candidates.cell_density + i);
    return points_over_density(query, from_cell, Float::load(candidates.lobe_density + i));
  });
}

void share_candidates(const SharedColumns& c, const CandidateQuery& query, size_t count,
                      const SharedValuesOf<float>& out, float sums[3]) {
  Vec3 sum(0.f);
  wide::for_lanes(count, [&](size_t i) {
    const Int cell = Int::load(c.cell + i);
    const Float factor = points_over_density(
        query, density_from_cells(query, Float::load(c.cell_density + i), cell),
        Float::load(c.lobe_density + i));
    const Vec3 ratio = Vec3::load_interleaved(c.radiance + 3 * i) * factor;
    const Float v = gather(query.cells.visibility, cell);
    const Vec3 known = load(c.f, i) * ratio * v;
    store(ratio, out.ratio, i);
    store(known, out.known, i);
    v.store(out.visibility + i);
    gather(query.cells.sigma, cell).store(out.sigma + i);
    sum = sum + known;
  });
  for (int k = 0; k < 3; ++k) sums[k] = wide::sum(sum[k]);
}

void weigh_taken(const TakenColumns& c, const TakenQuery& query, size_t count, float control[3],
                 float* block_sums) {
  const Vec3 variate(query.variate[0], query.variate[1], query.variate[2]);
  weigh(c.weight, c.uncertainty, count, control, block_sums, [&](size_t i, Vec3& sums) {
    const Vec3 weight = load(c.f, i) * load(c.shared.ratio, i) * query.points;
    sums = mul_add(Float::load(c.shared.visibility + i), weight, sums) -
           variate * load(c.shared.known, i);
    return Weighed{weight, Float::load(c.shared.sigma + i)};
  });
}

void weigh_connections(const ConnectedColumns& columns, const ConnectedQuery& query, size_t count,
                       float control[3], float* block_sums) {
  weigh_by(columns.weights, query.cells, count, control, block_sums, [&](size_t i, Int) {
    const Float from_eye = query.eye_rays * Float::load(columns.density + i);
    return 1.f / (1.f + from_eye * Float::load(columns.eye_ratio + i));
  });
}

void find_places(const SphereGrid& grid, const float* dx, const float* dy, const float* dz,
                 size_t count, float* places, uint32_t* quads) {
  const auto columns = static_cast<float>(grid.columns), rows = static_cast<float>(grid.rows);
  const float* const m = grid.to_local;
  wide::for_lanes(count, [&](size_t i) {
    const Vec3 d = load(dx, dy, dz, i);
    const Float x = dot(d, Vec3(m[0], m[1], m[2])), y = dot(d, Vec3(m[3], m[4], m[5])),
                z = dot(d, Vec3(m[6], m[7], m[8]));
    const auto positive = [&](Float column) { return column + select(column < 0.f, columns); };
    const Float from_zero = positive(atan2(x, -z) * (columns / (2 * kPi)));
    const Vec2 place(positive(from_zero - grid.first_column),
                     atan2(sqrt(mul_add(x, x, z * z)), y) * (rows * kInvPi));
    place.store_interleaved(places + 2 * i);
    const Int quad = clamp(to_int(place.y), 0, grid.rows - 1) * grid.columns +
                     clamp(to_int(place.x), 0, grid.columns - 1);
    quad.store(quads + i);
  });
}

}  // namespace kinome::simd
