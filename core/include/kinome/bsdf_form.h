#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinome/color.h"
#include "kinome/columns.h"
#include "kinome/export.h"
#include "kinome/math.h"

namespace kinome {

/// Closed form of a BSDF at one point, which kernels evaluate for many points at once. Cosines are
/// relative to the normal of Bsdf::reflection_frame().
struct BsdfForm {
  /// The kDiffuse lobe: f cos = diffuse x T(cos) cos / pi. T is 1 without a table. Otherwise it is
  /// wide::tabulated() over kTableSize values at cosines k / (kTableSize - 1), which live as long
  /// as the BSDF.
  static constexpr int kTableSize = 64;
  Rgb diffuse{0.f};
  const float* transmittance = nullptr;

  /// The kGlossy lobe: absent, without a closed form (kOther), or microfacets with Smith masking,
  /// f cos = specular F(wi . h) D(h) G1(wi) G1(wo) / (4 cos_i). G1 of Beckmann is the rational fit
  /// of Walter et al. 2007.
  enum class Glossy { kNone, kOther, kBeckmann, kGgx };
  Glossy glossy = Glossy::kNone;
  Rgb specular{0.f};
  float alpha_u = 1, alpha_v = 1;
  /// Fresnel reflectance: of a conductor (eta, k), or of a dielectric with relative index eta.x.
  bool is_conductor = false;
  Rgb eta{1.f}, k{0.f};

  /// True if the shading normal is perturbed (normal or bump map). Both lobes are then multiplied
  /// by wide::perturbed_normal_factor() of the cosine between the light and `surface_normal` (world
  /// space, on the viewer's side).
  bool has_perturbed_normal = false;
  Vec3 surface_normal{0, 0, 1};
  float bump_alpha2 = 0;  ///< roughness of the bumps, squared; see wide::bump_shadowing()

  /// True if the forms differ only in colours, roughness and perturbed normal.
  bool same_kind(const BsdfForm& other) const {
    return glossy == other.glossy && is_conductor == other.is_conductor && eta == other.eta &&
           k == other.k && has_perturbed_normal == other.has_perturbed_normal &&
           same_table(transmittance, other.transmittance);
  }
  /// True if both tables have the same values, wherever they are stored.
  static bool same_table(const float* a, const float* b) {
    return a == b || (a && b && std::equal(a, a + kTableSize, b));
  }
};

/// Distinct kinds of forms (see BsdfForm::same_kind()) at the points of blocks. Most scenes have
/// few kinds, however many points there are. Forms of further kinds, after the first kMaxKinds,
/// count as points without a form; this occurs if a texture varies the metal. Not thread-safe.
class KINOME_EXPORT BsdfFormKinds {
 public:
  /// Kind number of points without a form. Kinds are numbered from 1.
  static constexpr uint32_t kNone = 0;
  static constexpr size_t kMaxKinds = 64;

  /// Returns the number of the form's kind, and adds the kind if it is new. Returns kNone if
  /// kMaxKinds other kinds exist already.
  uint32_t number_of(const BsdfForm& form);
  /// Returns a form of this kind; `number` must not be kNone.
  const BsdfForm& operator[](uint32_t number) const { return kinds_[number - 1]; }
  void clear() { kinds_.clear(); }

 private:
  std::vector<BsdfForm> kinds_;
};

/// Forms of the points of a block: columns of BsdfForm.
struct BsdfFormBlock {
  Columns3 normal, tangent;  ///< of Bsdf::reflection_frame(), world space
  Columns3 diffuse;          ///< without a form: LobeReflectance::diffuse
  Columns3 specular;         ///< without a form: LobeReflectance::glossy
  float* alpha_u = nullptr;
  float* alpha_v = nullptr;
  Columns3 surface_normal;  ///< set if BsdfForm::has_perturbed_normal, like bump_alpha2
  float* bump_alpha2 = nullptr;
  uint32_t* kind = nullptr;  ///< number of the kind in `kinds`
  BsdfFormKinds* kinds = nullptr;

  BsdfFormBlock from(size_t i) const {
    return {normal.from(i), tangent.from(i), diffuse.from(i),        specular.from(i), alpha_u + i,
            alpha_v + i,    surface_normal.from(i), bump_alpha2 + i, kind + i,         kinds};
  }
};

}  // namespace kinome
