#include "coat.h"
#include "kinome/plugin.h"

/// A smooth dielectric coat over another BSDF, as in Mitsuba 0.6; see coat.h.
///
///     <bsdf type="coating">
///       <float name="int_ior" value="1.7"/>
///       <bsdf type="roughconductor"><string name="material" value="Cu"/></bsdf>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {KINOME_COAT_PARAMETERS};

/// Boundary that reflects like a mirror.
class SmoothBoundary {
 public:
  explicit SmoothBoundary(float eta) : eta_(eta) {}

  float transmittance(float cosine) const { return 1 - fresnel_dielectric(cosine, eta_); }
  Lobe lobe() const { return Lobe::kDelta; }
  BsdfValue value(const Vec3&, const Vec3&) const { return {}; }
  std::optional<BsdfSample> sample(const Vec3& wi, const Vec2&) const {
    return BsdfSample{mirrored(wi), 1, Rgb(fresnel_dielectric(wi.z, eta_)), Lobe::kDelta};
  }

 private:
  float eta_;
};

class Coating final : public Coat<SmoothBoundary> {
 public:
  explicit Coating(const Properties& props) : Coating(props, relative_ior(props)) {}

 private:
  Coating(const Properties& props, float eta) : Coat(props, eta, SmoothBoundary(eta)) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Coating, kinome::Category::kBsdf, "coating",
              "A smooth dielectric coat over another BSDF, as in Mitsuba 0.6.",
              kinome::kParameters);
