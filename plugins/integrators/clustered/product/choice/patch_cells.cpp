#include "clustered/product/choice/patch_cells.h"

#include <algorithm>
#include <cstddef>

#include "clustered/kernels/lane_blocks.h"
#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Normals of a flat patch are within a cone of this cosine. If they spread wider, the mean normal
/// and the others reflect the light of a cell at the horizon too differently.
constexpr float kFlatCosine = 0.999f;

/// Computes the transmittance toward the mean direction of each cell of these blocks.
void find_transmittance(const CellLight& light, const Patch& patch,
                        std::span<const uint32_t> blocks, Column<float>& transmittance) {
  const float* const table = patch.transmittance();
  const auto& axis = light.columns.axis;
  transmittance.resize(light.columns.count);
  using namespace wide;
  const wide::Vec3 normal(patch.normal);
  for_lanes_of_blocks(blocks, [&](size_t c) {
    const wide::Vec3 toward(Float::load(axis[0] + c), Float::load(axis[1] + c),
                            Float::load(axis[2] + c));
    tabulated(table, dot(normal, toward)).store(&transmittance[c]);
  });
}

/// Computes the light that the patch's mean normal reflects from cells that straddle its horizon.
/// Uses a few of the pass's points in each cell. They are far apart and begin at a random one, so
/// that different patches have different errors.
void find_straddling(const CellLight& light, const Patch& patch, uint64_t seed,
                     simd::PatchCells& cells) {
  using namespace wide;
  constexpr int kLog2Points = 2, kPoints = 1 << kLog2Points;
  constexpr int kFields = sizeof(CellPoint) / sizeof(float);
  static_assert(kFields == 8 && offsetof(CellPoint, weight) == 4 * sizeof(float));
  const wide::Vec3 normal(patch.normal);
  const float* const points = &light.points.points.data()->d.x;
  const uint32_t* const first = light.points.first.data();
  // The number of a cell's points is a power of two, at least four. Padding is cell 0 without
  // light.
  const Int start(static_cast<int32_t>(hash_words(seed, 0) >> 33));
  for_lanes(cells.mixed, [&](size_t i) {
    const Int cell = as_int(Uint::load(cells.ids() + cells.above + i));
    const Int begin = as_int(gather(first, cell));
    const Int last = as_int(gather(first + 1, cell)) - begin - 1;
    const Int stride = max(shift_right<kLog2Points>(last + 1), Int(1));
    Int at = start & last;
    Float sums[3] = {0.f, 0.f, 0.f};
    for (int k = 0; k < kPoints; ++k, at = (at + stride) & last) {
      const Int field = (begin + at) * kFields;
      const wide::Vec3 d(gather(points, field), gather(points + 1, field),
                         gather(points + 2, field));
      const Float share = max(dot(normal, d), Float(0.f)) * (1.f / kPoints);
      for (int c = 0; c < 3; ++c) sums[c] = mul_add(share, gather(points + 4 + c, field), sums[c]);
    }
    const auto column = [&](int c) { return cells.mixed_column(c) + i; };
    const Float v = Float::load(column(simd::PatchCells::kVisibility));
    for (int c = 0; c < 3; ++c) (v * sums[c]).store(column(simd::PatchCells::kStraddling + c));
    const Float mean = max((sums[0] + sums[1] + sums[2]) * (1 / 3.f), Float(0.f));
    const Float sigma = Float::load(column(simd::PatchCells::kSigma));
    (mean * sigma).store(column(simd::PatchCells::kStraddlingSigma));
  });
}

}  // namespace

void prepare_patch(const CellLight& light, const Patch& patch, const Visibility& visibility,
                   PreparedPatch& out, uint64_t seed) {
  const float sine = cone_sine(patch.cone_cosine);
  light.cells.blocks().find_facing(patch.normal, sine, out.blocks);
  out.transmittance.clear();
  if (patch.transmittance()) find_transmittance(light, patch, out.blocks, out.transmittance);
  const Vec3 local = light.cells.to_local(patch.normal);
  simd::classify_cells(light.columns, out.blocks, &local.x, sine, visibility.knowledge(),
                       out.transmittance.empty() ? nullptr : out.transmittance.data(), out.cells);
  out.cells.is_flat = light.horizon_terms && patch.cone_cosine > kFlatCosine;
  if (out.cells.is_flat) find_straddling(light, patch, seed, out.cells);
}

void PreparedPatches::begin_tile(size_t count, uint64_t seed) {
  seed_ = seed;
  if (entries_.size() < count) entries_.resize(count);
  for (Entry& entry : entries_) entry.ready = false;
}

const PreparedPatch& PreparedPatches::get(size_t index, const Patch& patch,
                                          const Visibility& visibility) {
  Entry& entry = entries_[index];
  if (!entry.ready) {
    entry.ready = true;
    prepare_patch(light_, patch, visibility, entry.prepared, hash_words(seed_, index));
  }
  return entry.prepared;
}

simd::GroupNormal group_normal(const DistantCells& cells, const Vec3& n, float cone_cosine) {
  const Vec3 local = cells.to_local(n);
  return {{n.x, n.y, n.z}, {local.x, local.y, local.z}, cone_sine(cone_cosine)};
}

}  // namespace kinome
