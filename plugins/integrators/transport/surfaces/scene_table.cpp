#include "transport/surfaces/scene_table.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

namespace kinome::transport {

namespace {

bool scatters(const Bsdf& bsdf) {
  return any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy));
}

}  // namespace

SceneTable::SceneTable(const Scene& scene, std::span<const Bsdf* const> phases,
                       const LightGroups& groups)
    : scene_(scene) {
  const auto& shapes = scene.shapes();
  // Materials in the order of their first use in the scene. An order by address would differ
  // between runs.
  std::map<const Bsdf*, uint32_t> order;
  for (const auto& shape : shapes) {
    order.try_emplace(&shape->bsdf(), static_cast<uint32_t>(order.size()));
  }
  std::vector<uint32_t> ids(shapes.size());
  std::iota(ids.begin(), ids.end(), 0u);
  const auto key = [&](uint32_t id) {
    const Bsdf& bsdf = shapes[id]->bsdf();
    return std::tuple(bsdf.lobes() == Lobe::kNone, !scatters(bsdf), order.at(&bsdf));
  };
  std::stable_sort(ids.begin(), ids.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  const size_t all = shapes.size() + phases.size();
  row_of_.resize(all);
  const auto no_row = static_cast<uint32_t>(all);
  emitting_row_of_.resize(all, no_row);
  passing_row_of_.resize(all, no_row);
  for (const Bsdf* phase : phases) {
    row_of_[shapes.size() + rows_.size()] = static_cast<uint32_t>(rows_.size());
    rows_.push_back({nullptr, phase, nullptr});
    ++scattering_, ++reflecting_;
  }
  for (const uint32_t id : ids) {
    const Shape& shape = *shapes[id];
    row_of_[id] = static_cast<uint32_t>(rows_.size());
    if (shape.emitter()) emitting_row_of_[id] = row_of_[id];
    if (shape.bsdf().has_null_lobe()) {
      passing_row_of_[id] = row_of_[id];
      has_null_lobe_ = true;
    }
    rows_.push_back({&shape, &shape.bsdf(), shape.emitter()});
    if (scatters(shape.bsdf())) ++scattering_;
    if (shape.bsdf().lobes() != Lobe::kNone) ++reflecting_;
  }
  set_groups(groups);
}

void SceneTable::set_groups(const LightGroups& groups) {
  const auto& emitters = scene_.emitters();
  group_offsets_.resize(emitters.size());
  if (groups.is_empty()) return;
  light_groups_ = groups.names().size();
  const auto offset = [&](const Emitter& emitter) {
    return groups.group_of(emitter) * kGroupStride;
  };
  for (size_t e = 0; e < emitters.size(); ++e) {
    group_offsets_[e] = static_cast<uint32_t>(offset(*emitters[e]));
  }
  for (Row& row : rows_) {
    if (row.emitter) row.group_offset = offset(*row.emitter);
  }
  if (scene_.environment()) environment_offset_ = offset(*scene_.environment());
}

}  // namespace kinome::transport
