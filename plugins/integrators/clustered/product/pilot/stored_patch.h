#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <shared_mutex>

#include "clustered/product/tiles/patches.h"

namespace kinome {

/// Values that many patches share. Thread-safe. Addresses are valid until clear().
class SharedOfPatches {
 public:
  using Probed = std::array<float, BsdfForm::kTableSize>;

  /// Returns a form of the same kind (BsdfForm::same_kind). There are about as many kinds as
  /// materials.
  const BsdfForm* form(const BsdfForm& form);
  /// Keeps a table of Patch::probed and returns its number, from 1 on. Returns 0 for nullptr.
  uint32_t add(std::shared_ptr<const Probed> probed);
  std::shared_ptr<const Probed> probed(uint32_t number) const;
  void clear();

 private:
  mutable std::shared_mutex mutex_;
  std::deque<BsdfForm> forms_;
  std::deque<std::shared_ptr<const Probed>> probed_;
};

/// A Patch in half of its memory, because large images have millions of patches. Leaves out the
/// members that only planning uses (Patch::uncertainty and mean_sigma) and those of Patch::form
/// that no patch uses (diffuse, surface_normal).
class StoredPatch : public PatchValues {
 public:
  StoredPatch(const Patch& patch, SharedOfPatches& shared);
  Patch restored(const SharedOfPatches& shared) const;
  /// Stores the members that learning sets.
  void set_learned(const Patch& patch);

 private:
  const BsdfForm* form_;  ///< of the same kind
  Rgb specular_;
  float alpha_u_, alpha_v_;  ///< of the form if it is a microfacet's, else of the lobe
  uint32_t probed_;
};

}  // namespace kinome
