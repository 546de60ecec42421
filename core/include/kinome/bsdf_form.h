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

/// A BSDF at one point in a form that kernels evaluate for many points at once; cosines are to the
/// normal of reflection_frame.
struct BsdfForm {
  /// The kDiffuse lobe: f cos = diffuse x T(cos) cos / pi, T being 1, or wide::tabulated of
  /// kTableSize values at cosines k / (kTableSize - 1), which live as long as the BSDF.
  static constexpr int kTableSize = 64;
  Rgb diffuse{0.f};
  const float* transmittance = nullptr;

  /// The kGlossy lobe: none, one that has no such form, or microfacets with Smith's masking,
  /// f cos = specular F(wi . h) D(h) G1(wi) G1(wo) / (4 cos_i). Beckmann's G1 is Walter et al.
  /// 2007's rational fit.
  enum class Glossy { kNone, kOther, kBeckmann, kGgx };
  Glossy glossy = Glossy::kNone;
  Rgb specular{0.f};
  float alpha_u = 1, alpha_v = 1;
  /// Fresnel's reflectance: of a dielectric of relative index eta.x, or of a conductor.
  bool is_conductor = false;
  Rgb eta{1.f}, k{0.f};

  /// Of a normal that was turned away from the surface's own: both lobes are multiplied by
  /// wide::turned_factor of the cosine between the light and `surface_normal` (world space, on the
  /// viewer's side).
  bool is_turned = false;
  Vec3 surface_normal{0, 0, 1};
  float bump_alpha2 = 0;  ///< see wide::bump_shadowing

  /// Nothing but colours, roughness and the turned normal differs.
  bool same_kind(const BsdfForm& other) const {
    return glossy == other.glossy && is_conductor == other.is_conductor && eta == other.eta &&
           k == other.k && is_turned == other.is_turned &&
           same_table(transmittance, other.transmittance);
  }
  /// Of the same values, wherever they are.
  static bool same_table(const float* a, const float* b) {
    return a == b || (a && b && std::equal(a, a + kTableSize, b));
  }
};

/// The kinds of forms that the points of blocks have: a few, whatever the number of points. Points
/// of more kinds than kMost, as where a texture says what metal it is, count as having no form. Not
/// thread-safe.
class KINOME_EXPORT BsdfFormKinds {
 public:
  /// The number of points that have no form; those of kinds follow.
  static constexpr uint32_t kNone = 0;
  static constexpr size_t kMost = 64;

  /// The number of a form's kind, which is added if it is new and there is room.
  uint32_t number_of(const BsdfForm& form);
  /// A form of that kind; number is not kNone.
  const BsdfForm& operator[](uint32_t number) const { return kinds_[number - 1]; }
  void clear() { kinds_.clear(); }

 private:
  std::vector<BsdfForm> kinds_;
};

/// BsdfForm by columns, and what it belongs to.
struct BsdfFormBlock {
  Columns3 normal, tangent;  ///< of Bsdf::reflection_frame, world space
  Columns3 diffuse;          ///< of points without a form: LobeReflectance::diffuse
  Columns3 specular;         ///< of points without a form: LobeReflectance::glossy
  float* alpha_u = nullptr;
  float* alpha_v = nullptr;
  Columns3 surface_normal;  ///< this and the next: where the form is_turned
  float* bump_alpha2 = nullptr;
  uint32_t* kind = nullptr;  ///< number in `kinds`
  BsdfFormKinds* kinds = nullptr;

  BsdfFormBlock from(size_t i) const {
    return {normal.from(i), tangent.from(i), diffuse.from(i),        specular.from(i), alpha_u + i,
            alpha_v + i,    surface_normal.from(i), bump_alpha2 + i, kind + i,         kinds};
  }
};

}  // namespace kinome
