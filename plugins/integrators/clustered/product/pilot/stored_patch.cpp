#include "clustered/product/pilot/stored_patch.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace kinome {
namespace {

/// Maximum number of forms that a new one is compared with.
constexpr ptrdiff_t kMaxCompared = 64;

}  // namespace

const BsdfForm* SharedOfPatches::form(const BsdfForm& form) {
  // Only the latest ones are compared, because textured materials may have a form for each patch.
  const auto find = [&]() -> const BsdfForm* {
    const auto end = forms_.rbegin() + std::min<ptrdiff_t>(std::ssize(forms_), kMaxCompared);
    const auto found = std::find_if(
        forms_.rbegin(), end, [&](const BsdfForm& known) { return known.same_kind(form); });
    return found == end ? nullptr : &*found;
  };
  {
    const std::shared_lock lock(mutex_);
    if (const BsdfForm* const known = find()) return known;
  }
  const std::unique_lock lock(mutex_);
  const BsdfForm* const known = find();
  return known ? known : &forms_.emplace_back(form);
}

uint32_t SharedOfPatches::add(std::shared_ptr<const Probed> probed) {
  if (!probed) return 0;
  const std::unique_lock lock(mutex_);
  probed_.push_back(std::move(probed));
  return static_cast<uint32_t>(probed_.size());
}

std::shared_ptr<const SharedOfPatches::Probed> SharedOfPatches::probed(uint32_t number) const {
  if (number == 0) return nullptr;
  const std::shared_lock lock(mutex_);
  return probed_[number - 1];
}

void SharedOfPatches::clear() {
  const std::unique_lock lock(mutex_);
  forms_.clear();
  probed_.clear();
}

StoredPatch::StoredPatch(const Patch& patch, SharedOfPatches& shared)
    : bsdf(patch.bsdf),
      normal(patch.normal),
      position(patch.position),
      records_end(patch.records_end),
      count(patch.count),
      form_(shared.form(patch.form)),
      viewer_(patch.viewer),
      cone_cosine_(patch.cone_cosine),
      tolerance_(patch.tolerance),
      diffuse_(patch.diffuse),
      glossy_reflectance_(patch.glossy_reflectance),
      specular_(patch.form.specular),
      alpha_u_(is_microfacet(patch.form) ? patch.form.alpha_u : patch.lobe.alpha_u),
      alpha_v_(is_microfacet(patch.form) ? patch.form.alpha_v : patch.lobe.alpha_v),
      glossy_(patch.glossy),
      cell_share_(patch.cell_share),
      eye_rays_(patch.eye_rays),
      probed_(shared.add(patch.probed)),
      is_described_(patch.is_described),
      is_uniform_(patch.is_uniform) {
  set_learned(patch);
}

void StoredPatch::set_learned(const Patch& patch) {
  mean_visibility_ = patch.mean_visibility;
  lamp_visibility_ = patch.lamp_visibility;
  trust_ = patch.trust;
}

Patch StoredPatch::restored(const SharedOfPatches& shared) const {
  Patch patch;
  patch.bsdf = bsdf;
  patch.normal = normal;
  patch.position = position;
  patch.viewer = viewer_;
  patch.cone_cosine = cone_cosine_;
  patch.tolerance = tolerance_;
  patch.diffuse = diffuse_;
  patch.glossy_reflectance = glossy_reflectance_;
  patch.is_described = is_described_;
  patch.form = *form_;
  patch.form.specular = specular_;
  if (is_microfacet(patch.form)) {
    patch.form.alpha_u = alpha_u_;
    patch.form.alpha_v = alpha_v_;
    patch.lobe = microfacet_lobe(patch.form);
  } else {
    patch.lobe = {alpha_u_, alpha_v_};
  }
  patch.is_uniform = is_uniform_;
  patch.probed = shared.probed(probed_);
  patch.count = count;
  patch.records_end = records_end;
  patch.glossy = glossy_;
  patch.cell_share = cell_share_;
  patch.mean_visibility = mean_visibility_;
  patch.lamp_visibility = lamp_visibility_;
  patch.eye_rays = eye_rays_;
  patch.trust = trust_;
  return patch;
}

}  // namespace kinome
