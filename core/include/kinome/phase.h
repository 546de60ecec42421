#pragma once

#include <array>

#include "kinome/bsdf.h"
#include "kinome/columns.h"
#include "kinome/math.h"
#include "kinome/object.h"

namespace kinome {

/// Point in a medium, seen along a ray.
struct MediumPoint {
  Vec3 p{0.f};  ///< world space
  Frame frame;  ///< n is the unit direction toward the ray's origin
};

/// Points in media, each seen along a ray: columns of MediumPoint.
struct MediumPointBlock {
  size_t count = 0;
  Columns3 p;
  Columns3 s, t, n;

  MediumPoint at(size_t i) const { return {p.at(i), {s.at(i), t.at(i), n.at(i)}}; }
};

/// Direction sampled from a phase function.
struct PhaseSample {
  Vec3 wo{0, 0, 1};  ///< unit, in the point's frame
  float pdf = 0;     ///< per solid angle; equal to eval(); 0 if sampling fails
};

/// Henyey-Greenstein function with a weight.
struct HgLobe {
  float g = 0;
  float weight = 1;
};

/// Angular distribution of the light that a medium scatters [1/sr]. Its integral over all
/// directions wo is 1, and sample() draws from it exactly. So a sample's weight is always 1.
///
/// Directions are unit vectors in the point's frame. wo points away from the point, as for BSDFs:
/// light that isn't deflected has wo = (0, 0, -1), and the cosine of the deflection is -wo.z.
class KINOME_EXPORT Phase : public Object {
 public:
  /// Evaluates the phase function, which is also the density of sample() per solid angle.
  virtual float eval(const MediumPoint& point, const Vec3& wo) const = 0;
  /// Samples a direction; u1 may choose a lobe, u2 the direction.
  virtual PhaseSample sample(const MediumPoint& point, float u1, const Vec2& u2) const = 0;
  /// Block versions. Default: point by point.
  virtual void eval_block(const MediumPointBlock& points, const Columns3& wo, float* value) const;
  virtual void sample_block(const MediumPointBlock& points, const float* u1, const Columns2& u2,
                            const Columns3& wo, float* pdf) const;

  /// Approximation by one or two Henyey-Greenstein lobes, whose weights add up to 1. Only
  /// importance functions use it.
  virtual std::array<HgLobe, 2> lobes() const = 0;

  /// True if the medium's extinction depends on the direction of the ray, by projected_area().
  bool is_oriented() const { return is_oriented_; }
  /// Factor of the extinction at the world-space point p for rays of world-space direction d.
  virtual float projected_area(const Vec3& /*p*/, const Vec3& /*d*/) const { return 1; }
  /// Block version. Default: point by point.
  virtual void projected_area_block(const Columns3& p, const Columns3& d, size_t count,
                                    float* area) const;
  /// Bounds on projected_area().
  virtual float min_projected_area() const { return 1; }
  virtual float max_projected_area() const { return 1; }

 protected:
  bool is_oriented_ = false;
};

/// Phase function as a BSDF, for the stages that shade blocks of points. Points have
/// wi = (0, 0, 1), and f is the phase function, without a cosine.
class KINOME_EXPORT PhaseBsdf final : public Bsdf {
 public:
  /// `phase` must outlive the object.
  explicit PhaseBsdf(const Phase& phase);
  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override;
  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override;
  LobeReflectance reflectance(const SurfaceInteraction& si) const override;
  Rgb albedo(const SurfaceInteraction& /*si*/) const override { return Rgb(1.f); }
  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override;

 private:
  const Phase& phase_;
};

}  // namespace kinome
