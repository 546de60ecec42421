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

struct BsdfValue {
  Rgb f{0.f};     ///< BSDF x |cos theta_o| [1/sr]
  float pdf = 0;  ///< of sample() with the same mask, per solid angle of wo
};

struct BsdfSample {
  Vec3 wo{0, 0, 1};  ///< in the shading frame
  float pdf = 0;     ///< per solid angle; 1 for a delta lobe
  Rgb weight{0.f};   ///< f |cos theta_o| / pdf
  Lobe lobe = Lobe::kNone;
};

/// Light that goes straight through a point of a surface (Lobe::kNull).
struct NullTransmission {
  /// Share of the radiance arriving along -wi that leaves along wi: the mean of the weights of
  /// samples with Lobe::kNull, where all others count as 0.
  Rgb transmittance{0.f};
  /// Probability of a sample of all lobes to have Lobe::kNull.
  float probability = 0;
};

/// How much a point reflects, split as Åkerlund 2008, eq. 4.5 does: |kd| and |ks|. Estimates are
/// enough, since only importance depends on them; where a part is zero its lobes must be, too.
struct LobeReflectance {
  Rgb diffuse{0.f};
  Rgb glossy{0.f};
};

/// Reflection at a surface, and transmission through it. Directions are unit vectors in the shading
/// frame `si.frame`, away from the surface; si.wi points to the viewer. Renderers ask for blocks of
/// points (shade_block, describe_block); a BSDF that has but the functions of single points is asked
/// for one after another.
class KINOME_EXPORT Bsdf : public Object {
 public:
  /// The lobes that any point of the surface may have.
  Lobe lobes() const { return lobes_; }
  /// True where f is reflectance().diffuse / pi for any two directions on one side of the shading
  /// plane (or 0 for that side), and there are no other lobes.
  bool is_lambertian() const { return is_lambertian_; }

  /// True where light may go through: wi and wo may lie on different sides.
  bool transmits() const { return transmits_; }
  /// True where it may by other lobes than Lobe::kDelta.
  bool scatters_through() const { return scatters_through_; }
  /// True where samples may have Lobe::kNull. null_transmission() then states their share.
  bool passes_straight() const { return passes_straight_; }
  /// Index of refraction behind the surface over that in front of it, where light goes through; 1:
  /// it isn't bent. Samples with Lobe::kNull aren't bent in any case. Values and weights are those
  /// of radiance, which is multiplied by the squared ratio of the indices on its way through (Veach
  /// 1997, 5.2); power that light carries isn't.
  float relative_index() const { return relative_index_; }

  /// True where the normal that is reflected about, or what it shadows, depends on si.wi, so that
  /// f(wi, wo) may be more than 0 for a wo from where sample() never goes to wi.
  bool turns_to_viewer() const { return turns_to_viewer_; }

  /// f(wi, wo) |cos theta_o| and the density of sample(), both of the lobes in `mask` only. Delta
  /// lobes give zero. f != 0 implies pdf != 0.
  virtual BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const = 0;
  /// A direction from the lobes in `mask`, of which the sample has one; beside kDelta it may have
  /// kNull. nullopt where none can be had (wi below the horizon, or
  /// the sample fell there). u1 chooses the lobe, u2 the direction.
  virtual std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                           const Vec2& u2) const = 0;
  /// Light that goes straight through, as seen from si.wi. Mandatory if passes_straight_ is set.
  /// Default: none.
  virtual NullTransmission null_transmission(const SurfaceInteraction& /*si*/) const { return {}; }
  /// As seen from si.wi, on its side of the surface. Stands for other viewers of that side, too,
  /// where light is taken from: a part that any of them sees isn't zero.
  virtual LobeReflectance reflectance(const SurfaceInteraction& si) const = 0;
  /// What integrator `aov` shows as the surface's colour, as Mitsuba has it: the reflectance of a
  /// diffuse part, whatever lies over it. Default: pi f(wi, normal).
  virtual Rgb albedo(const SurfaceInteraction& si) const {
    return eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1)).f * kPi;
  }

  /// World frame around the normal that the BSDF itself uses, on the side where light that reaches
  /// the viewer comes from: reflection is zero where dot(frame.n, direction) <= 0, for the
  /// direction of the light and for that of the viewer. A normal map perturbs it, a two-sided
  /// surface turns it to the viewer.
  virtual Frame reflection_frame(const SurfaceInteraction& si) const { return si.frame; }

  /// eval_pdf of one direction and sample, of query.lobes, at each point of a block: both want the
  /// same set-up. Default: point by point.
  virtual void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                           const BsdfAnswer& answer) const;

  /// null_transmission at each point of a block. Default: point by point.
  virtual void null_transmission_block(const SurfaceBlock& points,
                                       const NullTransmissionBlock& out) const;

  /// At each point of a block, reflection_frame and the lobes other than kDelta in a form for
  /// kernels, the same that eval_pdf computes up to rounding; in place of a form that there isn't,
  /// the colours of reflectance(). Forms are only for points with wi on the side of
  /// reflection_frame. Default: there is none.
  virtual void describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const;
  /// The form that describe_block has for a point; nullopt: none.
  std::optional<BsdfForm> form(const SurfaceInteraction& si) const;

 protected:
  /// What describe_block says of point i where it has no form.
  void describe_by_colours(const SurfaceBlock& points, size_t i, const BsdfFormBlock& out) const;

  Lobe lobes_ = Lobe::kAll;
  bool is_lambertian_ = false;
  bool transmits_ = false;
  bool scatters_through_ = false;
  bool passes_straight_ = false;
  float relative_index_ = 1;
  bool turns_to_viewer_ = false;
};

}  // namespace kinome
