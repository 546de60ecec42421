#include "clustered/kernels/candidate_kernels.h"

// A scalar target, too, wherever the baseline is one: tests compare with it.
#define HWY_COMPILE_ALL_ATTAINABLE
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clustered/kernels/candidate_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace kinome::simd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kLobeLanes>;
using V = hn::Vec<Tag>;
using IndexTag = hn::RebindToSigned<Tag>;
using Index = hn::Vec<IndexTag>;

constexpr float kPi = std::numbers::pi_v<float>;

/// weight = f x radiance x factor(first candidate of a vector), with control terms and
/// uncertainties.
template <class Factor>
HWY_INLINE void Weigh(const WeightColumns& c, const CellKnowledgeColumns& cells, size_t count,
                      float control[3], float* block_sums, const Factor& factor_of) {
  const Tag d;
  const IndexTag di;
  const size_t lanes = hn::Lanes(d);
  const V zero = hn::Zero(d);
  V sums[3] = {zero, zero, zero};
  for (size_t block = 0; block < count / kLobeLanes; ++block) {
    V block_sum = zero;
    for (size_t i = block * kLobeLanes; i < (block + 1) * kLobeLanes; i += lanes) {
      const Index cell = hn::BitCast(di, hn::LoadU(hn::RebindToUnsigned<Tag>(), c.cell + i));
      const V factor = factor_of(i, cell);
      V radiance[3];
      hn::LoadInterleaved3(d, c.radiance + 3 * i, radiance[0], radiance[1], radiance[2]);
      const V v = hn::GatherIndex(d, cells.visibility, cell);
      V mean = zero;
      for (int k = 0; k < 3; ++k) {
        const V weight = hn::Mul(hn::Mul(hn::LoadU(d, c.f[k] + i), radiance[k]), factor);
        hn::StoreU(weight, d, c.weight[k] + i);
        sums[k] = hn::MulAdd(v, weight, sums[k]);
        mean = hn::Add(mean, weight);
      }
      const V uncertainty = hn::Mul(hn::Mul(hn::Abs(mean), hn::Set(d, 1 / 3.f)),
                                    hn::GatherIndex(d, cells.sigma, cell));
      hn::StoreU(uncertainty, d, c.uncertainty + i);
      block_sum = hn::Add(block_sum, uncertainty);
    }
    block_sums[block] = hn::GetLane(hn::SumOfLanes(d, block_sum));
  }
  for (int k = 0; k < 3; ++k) control[k] = hn::GetLane(hn::SumOfLanes(d, sums[k]));
}

void WeighCandidates(const CandidateColumns& c, const CandidateQuery& q, size_t count,
                     float control[3], float* block_sums) {
  const Tag d;
  Weigh(c.weights, q.cells, count, control, block_sums, [&](size_t i, Index cell) {
    const V share = hn::Mul(hn::GatherIndex(d, q.importance, cell), hn::Set(d, q.inverse_total));
    const V from_cell = hn::Mul(hn::LoadU(d, c.cell_density + i), share);
    hn::StoreU(from_cell, d, c.cell_density + i);
    const V density =
        hn::MulAdd(hn::Set(d, q.from_cells), from_cell,
                   hn::Mul(hn::Set(d, q.from_lobe), hn::LoadU(d, c.lobe_density + i)));
    return hn::IfThenElseZero(hn::Gt(density, hn::Zero(d)),
                              hn::Div(hn::Set(d, q.points), hn::Max(density, hn::Set(d, 1e-37f))));
  });
}

void WeighConnections(const ConnectedColumns& c, const ConnectedQuery& q, size_t count,
                      float control[3], float* block_sums) {
  const Tag d;
  Weigh(c.weights, q.cells, count, control, block_sums, [&](size_t i, Index) {
    const V by_eye = hn::Mul(hn::Mul(hn::Set(d, q.eye_rays), hn::LoadU(d, c.density + i)),
                             hn::LoadU(d, c.eye_ratio + i));
    return hn::Div(hn::Set(d, 1.f), hn::Add(hn::Set(d, 1.f), by_eye));
  });
}

/// Of x >= 0 and y >= 0, in [0, pi / 2]; the polynomial of Moshier's Cephes library (atanf).
HWY_INLINE V atan2_first_quadrant(V y, V x) {
  const Tag d;
  const V large = hn::Max(hn::Max(x, y), hn::Set(d, 1e-37f));
  const V small = hn::Min(x, y);
  const auto reduced = hn::Gt(small, hn::Mul(large, hn::Set(d, 0.414213562f)));
  const V t = hn::Div(hn::IfThenElse(reduced, hn::Sub(small, large), small),
                      hn::IfThenElse(reduced, hn::Add(small, large), large));
  const V z = hn::Mul(t, t);
  V p = hn::MulAdd(z, hn::Set(d, 8.05374449538e-2f), hn::Set(d, -1.38776856032e-1f));
  p = hn::MulAdd(z, p, hn::Set(d, 1.99777106478e-1f));
  p = hn::MulAdd(z, p, hn::Set(d, -3.33329491539e-1f));
  V angle = hn::MulAdd(hn::Mul(p, z), t, t);
  angle = hn::Add(angle, hn::IfThenElseZero(reduced, hn::Set(d, kPi / 4)));
  return hn::IfThenElse(hn::Gt(y, x), hn::Sub(hn::Set(d, kPi / 2), angle), angle);
}

void FindPlaces(const SphereGrid& grid, const float* dx, const float* dy, const float* dz,
                size_t count, float* places, uint32_t* quads) {
  const Tag d;
  const IndexTag di;
  const V zero = hn::Zero(d);
  const V pi = hn::Set(d, kPi), turn = hn::Set(d, 2 * kPi);
  const auto columns = static_cast<float>(grid.columns), rows = static_cast<float>(grid.rows);
  const V x_scale = hn::Set(d, columns / (2 * kPi)), y_scale = hn::Set(d, rows / kPi);
  const V origin = hn::Set(d, grid.first_column);
  const Index last_column = hn::Set(di, grid.columns - 1), last_row = hn::Set(di, grid.rows - 1);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const V wx = hn::LoadU(d, dx + i), wy = hn::LoadU(d, dy + i), wz = hn::LoadU(d, dz + i);
    const auto row = [&](int k) {
      const float* const m = grid.to_local + k;
      const V yz = hn::MulAdd(hn::Set(d, m[1]), wy, hn::Mul(hn::Set(d, m[2]), wz));
      return hn::MulAdd(hn::Set(d, m[0]), wx, yz);
    };
    const V lx = row(0), ly = row(3), lz = hn::Neg(row(6));
    V phi = atan2_first_quadrant(hn::Abs(lx), hn::Abs(lz));
    phi = hn::IfThenElse(hn::Lt(lz, zero), hn::Sub(pi, phi), phi);
    phi = hn::IfThenElse(hn::Lt(lx, zero), hn::Sub(turn, phi), phi);
    V x = hn::MulSub(phi, x_scale, origin);
    x = hn::Add(x, hn::IfThenElseZero(hn::Lt(x, zero), hn::Set(d, columns)));
    const V sine = hn::Sqrt(hn::MulAdd(lx, lx, hn::Mul(lz, lz)));
    V theta = atan2_first_quadrant(sine, hn::Abs(ly));
    theta = hn::IfThenElse(hn::Lt(ly, zero), hn::Sub(pi, theta), theta);
    const V y = hn::Mul(theta, y_scale);
    hn::StoreInterleaved2(x, y, d, places + 2 * i);
    const Index none = hn::Zero(di);
    const Index column = hn::Max(none, hn::Min(hn::ConvertTo(di, x), last_column));
    const Index line = hn::Max(none, hn::Min(hn::ConvertTo(di, y), last_row));
    const Index quad = hn::Add(hn::Mul(line, hn::Set(di, grid.columns)), column);
    hn::StoreU(hn::BitCast(hn::RebindToUnsigned<Tag>(), quad), hn::RebindToUnsigned<Tag>(),
               quads + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinome::simd {

HWY_EXPORT(WeighCandidates);
HWY_EXPORT(WeighConnections);
HWY_EXPORT(FindPlaces);

void weigh_candidates(const CandidateColumns& candidates, const CandidateQuery& query, size_t count,
                      float control[3], float* block_sums) {
  HWY_DYNAMIC_DISPATCH(WeighCandidates)(candidates, query, count, control, block_sums);
}

void weigh_connections(const ConnectedColumns& columns, const ConnectedQuery& query, size_t count,
                       float control[3], float* block_sums) {
  HWY_DYNAMIC_DISPATCH(WeighConnections)(columns, query, count, control, block_sums);
}

void find_places(const SphereGrid& grid, const float* dx, const float* dy, const float* dz,
                 size_t count, float* places, uint32_t* quads) {
  HWY_DYNAMIC_DISPATCH(FindPlaces)(grid, dx, dy, dz, count, places, quads);
}

}  // namespace kinome::simd
#endif
