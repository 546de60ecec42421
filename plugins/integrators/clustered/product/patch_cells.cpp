#include "clustered/product/patch_cells.h"

#include <algorithm>

namespace kinome {
namespace {

/// Of a cone's half angle; beyond a right angle all cells may straddle a horizon.
inline float cone_sine(float cosine) {
  return cosine > 0 ? safe_sqrt(1 - std::min(cosine * cosine, 1.f)) : 2.f;
}

/// Of each cell's mean direction.
void find_transmittance(const CellLight& light, const Patch& patch,
                        Column<float>& transmittance) {
  const float* const table = patch.transmittance();
  const auto& axis = light.columns.axis;
  transmittance.resize(light.columns.count);
  using namespace wide;
  const wide::Vec3 normal(patch.normal);
  for_lanes(transmittance.size(), [&](size_t c) {
    const wide::Vec3 toward(Float::load(axis[0] + c), Float::load(axis[1] + c),
                            Float::load(axis[2] + c));
    interpolate_transmittance(table, dot(normal, toward)).store(&transmittance[c]);
  });
}

}  // namespace

void prepare_patch(const CellLight& light, const Patch& patch, const Visibility& visibility,
                   PreparedPatch& out) {
  out.transmittance.clear();
  if (patch.transmittance()) find_transmittance(light, patch, out.transmittance);
  const Vec3 local = light.cells.to_local(patch.normal);
  simd::classify_cells(light.columns, &local.x, cone_sine(patch.cone_cosine),
                       visibility.knowledge(),
                       out.transmittance.empty() ? nullptr : out.transmittance.data(), out.cells);
}

void PreparedPatches::begin_tile(size_t count) {
  if (entries_.size() < count) entries_.resize(count);
  for (Entry& entry : entries_) entry.ready = false;
}

const PreparedPatch& PreparedPatches::get(size_t index, const Patch& patch,
                                          const Visibility& visibility) {
  Entry& entry = entries_[index];
  if (!entry.ready) {
    entry.ready = true;
    prepare_patch(light_, patch, visibility, entry.prepared);
  }
  return entry.prepared;
}

simd::GroupNormal group_normal(const DistantCells& cells, const Vec3& n, float cone_cosine) {
  const Vec3 local = cells.to_local(n);
  return {{n.x, n.y, n.z}, {local.x, local.y, local.z}, cone_sine(cone_cosine)};
}

}  // namespace kinome
