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

void share_candidates(const SharedColumns& c, const SharedQuery& query, size_t count,
                      const SharedValuesOf<float>& out, float sums[3]) {
  Vec3 sum(0.f);
  wide::for_lanes(count, [&](size_t i) {
    const Int cell = Int::load(c.cell + i);
    const Float from_cell =
        Float::load(c.cell_density + i) * (gather(query.importance, cell) * query.inverse_total);
    const Float density =
        query.from_cells * from_cell + query.from_lobe * Float::load(c.lobe_density + i);
    const Float factor = select(density > 0.f, 1.f / max(density, 1e-37f));
    const Vec3 ratio = Vec3::load_interleaved(c.radiance + 3 * i) * factor;
    const Float v = gather(query.cells.visibility, cell);
    const Vec3 f(Float::load(c.f[0] + i), Float::load(c.f[1] + i), Float::load(c.f[2] + i));
    const Vec3 known = f * ratio * v;
    const auto store = [i](const Vec3& value, float* const columns[3]) {
      value.x.store(columns[0] + i);
      value.y.store(columns[1] + i);
      value.z.store(columns[2] + i);
    };
    store(ratio, out.ratio);
    store(known, out.known);
    v.store(out.visibility + i);
    gather(query.cells.sigma, cell).store(out.sigma + i);
    sum = sum + known;
  });
  for (int k = 0; k < 3; ++k) sums[k] = wide::sum(sum[k]);
}

void weigh_taken(const TakenColumns& c, const TakenQuery& query, size_t count, float control[3],
                 float* block_sums) {
  Vec3 sums(0.f);
  const Vec3 variate(query.variate[0], query.variate[1], query.variate[2]);
  for (size_t block = 0; block < count / kLobeLanes; ++block) {
    Float block_sum = 0.f;
    for (size_t i = block * kLobeLanes; i < (block + 1) * kLobeLanes; i += kLanes) {
      const auto load = [i](const float* const columns[3]) {
        return Vec3(Float::load(columns[0] + i), Float::load(columns[1] + i),
                    Float::load(columns[2] + i));
      };
      const Vec3 weight = load(c.f) * load(c.shared.ratio) * query.points;
      weight.x.store(c.weight[0] + i);
      weight.y.store(c.weight[1] + i);
      weight.z.store(c.weight[2] + i);
      sums = mul_add(Float::load(c.shared.visibility + i), weight, sums) -
             variate * load(c.shared.known);
      const Float mean = (weight.x + weight.y + weight.z) * (1 / 3.f);
      const Float uncertainty = abs(mean) * Float::load(c.shared.sigma + i);
      uncertainty.store(c.uncertainty + i);
      block_sum += uncertainty;
    }
    block_sums[block] = sum(block_sum);
  }
  for (int k = 0; k < 3; ++k) control[k] += sum(sums[k]);
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
