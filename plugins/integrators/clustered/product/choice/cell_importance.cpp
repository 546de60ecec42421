#include "clustered/product/choice/cell_importance.h"

#include <algorithm>

namespace kinome {
namespace {

/// Factor of the lobe's squared roughness for drawing cells. It is above 1 because the lobe's tails
/// matter where the light is bright.
constexpr float kAlpha2Factor = 4;

}  // namespace

CellImportance::CellImportance(const CellLight& light)
    : light_(light),
      values_(light.columns.count),
      block_sums_(light.columns.count / simd::kCellLanes) {}

void CellImportance::find(const Lobe& lobe) {
  simd::GlossyQuery query;
  for (int axis = 0; axis < 3; ++axis) {
    query.normal[axis] = lobe.normal[axis];
    query.viewer[axis] = lobe.viewer[axis];
  }
  query.alpha2 = lobe.alpha2 * kAlpha2Factor;
  query.spread = std::clamp(1 - lobe.cosine, 0.f, 2.f);
  total_ = simd::glossy_importance(light_.columns, query, values_.data(), block_sums_.data());
}

std::span<const Comb::Hit> CellImportance::draw(uint32_t count, float offset) {
  double total = 0;
  for (const float sum : block_sums_) total += sum;
  Comb comb(total, count, offset);
  hits_.clear();
  comb.pass(values_.data(), block_sums_.data(), values_.size(), hits_);
  for (const Comb::Hit& hit : hits_) {
    __builtin_prefetch(&light_.points.pick(hit.stratum, hit.remainder));
  }
  return hits_;
}

}  // namespace kinome
