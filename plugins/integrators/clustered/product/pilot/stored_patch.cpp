#include "clustered/product/pilot/stored_patch.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace kinome {
namespace {

/// Maximum number of forms that a new one is compared with.
constexpr ptrdiff_t kMaxComparedForms = 64;

}  // namespace

const BsdfForm* SharedOfPatches::form(const BsdfForm& form) {
  // Only the latest ones are compared, because textured materials may have a form for each patch.
  const auto find = [&]() -> const BsdfForm* {
    const auto end = forms_.rbegin() + std::min<ptrdiff_t>(std::ssize(forms_), kMaxComparedForms);
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
    : PatchValues(patch),
      form_(shared.form(patch.form)),
      specular_(patch.form.specular),
      alpha_u_(is_microfacet(patch.form) ? patch.form.alpha_u : patch.lobe.alpha_u),
      alpha_v_(is_microfacet(patch.form) ? patch.form.alpha_v : patch.lobe.alpha_v),
      probed_(shared.add(patch.probed)) {}

void StoredPatch::set_learned(const Patch& patch) {
  mean_visibility = patch.mean_visibility;
  lamp_visibility = patch.lamp_visibility;
  trust = patch.trust;
}

Patch StoredPatch::restored(const SharedOfPatches& shared) const {
  Patch patch;
  static_cast<PatchValues&>(patch) = *this;
  patch.form = *form_;
  patch.form.specular = specular_;
  if (is_microfacet(patch.form)) {
    patch.form.alpha_u = alpha_u_;
    patch.form.alpha_v = alpha_v_;
    patch.lobe = microfacet_lobe(patch.form);
  } else {
    patch.lobe = {alpha_u_, alpha_v_};
  }
  patch.probed = shared.probed(probed_);
  return patch;
}

}  // namespace kinome
