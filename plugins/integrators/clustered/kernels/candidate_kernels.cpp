#include "clustered/kernels/candidate_kernels.h"

#include "clustered/kernels/lobe_kernels.h"
#include "kinome/wide/functions.h"

namespace kinome::simd {
namespace {

using wide::Float;
using wide::Int;
using wide::kLanes;
using wide::Vec2;
using wide::Vec3;

/// weight = f x radiance x factor(first candidate of a vector, their cells), with control terms and
/// uncertainties.
template <class Factor>
void weigh(const WeightColumns& c, const CellKnowledgeColumns& cells, size_t count,
           float control[3], float* block_sums, const Factor& factor) {
  Vec3 sums(0.f);
  for (size_t block = 0; block < count / kLobeLanes; ++block) {
    Float block_sum = 0.f;
    for (size_t i = block * kLobeLanes; i < (block + 1) * kLobeLanes; i += kLanes) {
      const Int cell = Int::load(c.cell + i);
      const Vec3 f(Float::load(c.f[0] + i), Float::load(c.f[1] + i), Float::load(c.f[2] + i));
      const Vec3 weight = f * Vec3::load_interleaved(c.radiance + 3 * i) * factor(i, cell);
      weight.x.store(c.weight[0] + i);
      weight.y.store(c.weight[1] + i);
      weight.z.store(c.weight[2] + i);
      sums = mul_add(gather(cells.visibility, cell), weight, sums);
      const Float mean = (weight.x + weight.y + weight.z) * (1 / 3.f);
      const Float uncertainty = abs(mean) * gather(cells.sigma, cell);
      uncertainty.store(c.uncertainty + i);
      block_sum += uncertainty;
    }
    block_sums[block] = sum(block_sum);
  }
  for (int k = 0; k < 3; ++k) control[k] = sum(sums[k]);
}

}  // namespace

void weigh_candidates(const CandidateColumns& candidates, const CandidateQuery& query, size_t count,
                      float control[3], float* block_sums) {
  const auto factor = [&](size_t i, Int cell) {
    const Float from_cell = Float::load(candidates.cell_density + i) *
                            (gather(query.importance, cell) * query.inverse_total);
    from_cell.store(candidates.cell_density + i);
    const Float from_lobe = Float::load(candidates.lobe_density + i);
    const Float density = query.from_cells * from_cell + query.from_lobe * from_lobe;
    return select(density > 0.f, query.points / max(density, 1e-37f));
  };
  weigh(candidates.weights, query.cells, count, control, block_sums, factor);
}

void weigh_connections(const ConnectedColumns& columns, const ConnectedQuery& query, size_t count,
                       float control[3], float* block_sums) {
  const auto factor = [&](size_t i, Int) {
    const Float from_eye = query.eye_rays * Float::load(columns.density + i);
    return 1.f / (1.f + from_eye * Float::load(columns.eye_ratio + i));
  };
  weigh(columns.weights, query.cells, count, control, block_sums, factor);
}

void find_places(const SphereGrid& grid, const float* dx, const float* dy, const float* dz,
                 size_t count, float* places, uint32_t* quads) {
  const auto columns = static_cast<float>(grid.columns), rows = static_cast<float>(grid.rows);
  const float* const m = grid.to_local;
  wide::for_lanes(count, [&](size_t i) {
    const Vec3 d(Float::load(dx + i), Float::load(dy + i), Float::load(dz + i));
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
