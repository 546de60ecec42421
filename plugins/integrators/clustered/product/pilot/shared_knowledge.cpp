#include "clustered/product/pilot/shared_knowledge.h"

#include <algorithm>

namespace kinome {

BsdfAddresses::BsdfAddresses(const Scene& scene) {
  for (const auto& shape : scene.shapes()) {
    const Bsdf* const bsdf = &shape->bsdf();
    if (number_.emplace(bsdf, static_cast<uint32_t>(all_.size())).second) all_.push_back(bsdf);
  }
}

void BsdfAddresses::transfer(const Bsdf*& bsdf, SharedBytes& bytes) const {
  uint32_t number = bytes.reads() ? 0 : number_.at(bsdf);
  bytes.value(number);
  bsdf = all_.at(number);
}

void BsdfAddresses::transfer(const float*& table, SharedBytes& bytes) {
  bool is_there = table != nullptr;
  bytes.value(is_there);
  if (!is_there) {
    table = nullptr;
    return;
  }
  Table values{};
  if (!bytes.reads()) std::copy(table, table + values.size(), values.begin());
  bytes.value(values);
  if (!bytes.reads()) return;
  auto known = std::find(tables_.begin(), tables_.end(), values);
  if (known == tables_.end()) known = tables_.insert(known, values);
  table = known->data();
}

void transfer(Patch& patch, SharedBytes& bytes, BsdfAddresses& addresses) {
  addresses.transfer(patch.bsdf, bytes);
  bytes.values(patch.normal, patch.position, patch.viewer, patch.cone_cosine, patch.tolerance,
               patch.diffuse, patch.glossy_reflectance, patch.is_described, patch.form,
               patch.is_uniform, patch.lobe, patch.count, patch.records_end, patch.glossy,
               patch.cell_share, patch.eye_rays);
  // The copied pointer belongs to another process.
  if (bytes.reads()) patch.form.transmittance = nullptr;
  addresses.transfer(patch.form.transmittance, bytes);
  transfer_learned(patch, bytes);
  bool is_probed = patch.probed != nullptr;
  bytes.value(is_probed);
  if (!is_probed) return;
  auto probed = patch.probed ? *patch.probed : std::array<float, BsdfForm::kTableSize>{};
  bytes.value(probed);
  if (bytes.reads()) patch.probed = std::make_shared<const decltype(probed)>(probed);
}

void transfer_learned(Patch& patch, SharedBytes& bytes) {
  bytes.values(patch.mean_visibility, patch.lamp_visibility, patch.trust);
}

}  // namespace kinome
