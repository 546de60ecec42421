#pragma once

#include <cstddef>
#include <optional>

#include "kinome/blocks.h"
#include "kinome/bsdf_form.h"
#include "kinome/color.h"
#include "kinome/interaction.h"
#include "kinome/lobe.h"
#include "kinome/object.h"

namespace kinome {

/// Value and density of a BSDF for a pair of directions.
struct BsdfValue {
  Rgb f{0.f};     ///< BSDF x |cos theta_o| [1/sr]
  float pdf = 0;  ///< density of sample() with the same mask, per solid angle of wo
};

/// Direction sampled from a BSDF.
struct BsdfSample {
  Vec3 wo{0, 0, 1};  ///< unit, in the shading frame
  float pdf = 0;     ///< per solid angle; 1 for a delta lobe
  Rgb weight{0.f};   ///< f |cos theta_o| / pdf
  Lobe lobe = Lobe::kNone;
};

/// Straight transmission through a surface point (Lobe::kNull).
struct NullTransmission {
  /// Fraction of the radiance arriving along -wi that leaves along wi: the mean weight of samples
  /// with Lobe::kNull, counting all other samples as 0.
  Rgb transmittance{0.f};
  float probability = 0;  ///< probability that a sample of all lobes has Lobe::kNull
};

/// Reflectance split into a diffuse and a glossy part (|kd| and |ks| of Åkerlund 2008, eq. 4.5).
/// Estimates suffice, because only importance functions use them. A part may be 0 only if its lobes
/// are 0.
struct LobeReflectance {
  Rgb diffuse{0.f};
  Rgb glossy{0.f};
};

/// Reflection from a surface and transmission through it. All directions are unit vectors in the
/// shading frame `si.frame` and point away from the surface; si.wi points to the viewer.
///
/// Integrators call shade_block() and describe_block(). BSDFs that implement only the scalar
/// functions are evaluated point by point.
class KINOME_EXPORT Bsdf : public Object {
 public:
  /// Lobes that a point of the surface may have.
  Lobe lobes() const { return lobes_; }
  /// True if all lobes together are Lambertian: f is reflectance().diffuse / pi for any two
  /// directions on the same side of the shading plane (or 0 on one of the sides), and 0 otherwise.
  bool is_lambertian() const { return is_lambertian_; }

  /// True if light may pass through the surface: wi and wo may lie on different sides.
  bool transmits() const { return transmits_; }
  /// True if lobes other than Lobe::kDelta may transmit.
  bool has_rough_transmission() const { return has_rough_transmission_; }
  /// True if samples may have Lobe::kNull. null_transmission() is then mandatory.
  bool has_null_lobe() const { return has_null_lobe_; }
  /// True if null_transmission() is 1 everywhere. Such a surface only separates media.
  bool is_invisible() const { return is_invisible_; }
  /// Index of refraction on the back side divided by that on the front side; 1 without refraction.
  /// Samples with Lobe::kNull are never refracted. Values and weights are those of radiance, which
  /// refraction scales by the squared ratio (Veach 1997, 5.2); power isn't scaled.
  float relative_index() const { return relative_index_; }

  /// True if the normal of reflection, or the shadowing around it, depends on si.wi. Then f(wi, wo)
  /// may be positive although sample() as seen from wo never returns wi.
  bool turns_to_viewer() const { return turns_to_viewer_; }

  /// Evaluates f(wi, wo) |cos theta_o| and the density of sample(), both for the lobes in `mask`.
  /// Delta lobes contribute 0. The density is positive wherever f is not 0.
  virtual BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const = 0;
  /// Samples a direction from one of the lobes in `mask`; u1 chooses the lobe, u2 the direction.
  /// The sample's lobe is one bit of `mask`, plus kNull for straight transmission by kDelta.
  /// Returns nullopt if sampling fails (wi or the sampled direction is below the horizon).
  virtual std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                           const Vec2& u2) const = 0;
  /// Straight transmission as seen from si.wi. Mandatory if has_null_lobe_ is set. Default: none.
  virtual NullTransmission null_transmission(const SurfaceInteraction& /*si*/) const { return {}; }
  /// Reflectance on the side of si.wi. Callers also use it for other viewers on that side, so a
  /// part may be 0 only if it is 0 for all of them.
  virtual LobeReflectance reflectance(const SurfaceInteraction& si) const = 0;
  /// Surface colour for the `albedo` channel of integrator `aov`, as in Mitsuba: the reflectance of
  /// the diffuse part, regardless of coatings. Default: pi f(wi, normal).
  virtual Rgb albedo(const SurfaceInteraction& si) const {
    return eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1)).f * kPi;
  }

  /// World-space frame around the normal that the BSDF itself uses, on the side of the reflected
  /// light. Reflection is 0 if dot(frame.n, direction) <= 0 for the direction of the light or of
  /// the viewer. Normal maps perturb this frame; two-sided BSDFs turn it to the viewer.
  virtual Frame reflection_frame(const SurfaceInteraction& si) const { return si.frame; }

  /// Evaluates eval_pdf() for one direction and draws one sample() at each point of a block, for
  /// the lobes in query.lobes. Default: point by point.
  virtual void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                           const BsdfAnswer& answer) const;

  /// Evaluates null_transmission() at each point of a block. Default: point by point.
  virtual void null_transmission_block(const SurfaceBlock& points,
                                       const NullTransmissionBlock& out) const;

  /// Computes reflection_frame() and the BSDF without its kDelta lobes as a closed-form BsdfForm,
  /// at each point of a block. The form agrees with eval_pdf() up to rounding. For points without a
  /// form, writes the colours of reflectance(). Forms exist only for points whose wi is on the side
  /// of reflection_frame(). Default: no forms.
  virtual void describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const;
  /// Returns the form that describe_block() computes for a point, or nullopt.
  std::optional<BsdfForm> form(const SurfaceInteraction& si) const;

 protected:
  /// Writes the output of describe_block() for a point i without a form.
  void describe_by_colours(const SurfaceBlock& points, size_t i, const BsdfFormBlock& out) const;

  Lobe lobes_ = Lobe::kAll;
  bool is_lambertian_ = false;
  bool transmits_ = false;
  bool has_rough_transmission_ = false;
  bool has_null_lobe_ = false;
  bool is_invisible_ = false;
  float relative_index_ = 1;
  bool turns_to_viewer_ = false;
};

}  // namespace kinome
