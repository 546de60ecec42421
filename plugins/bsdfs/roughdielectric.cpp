#include "kinome/plugin.h"
#include "rough_dielectric.h"

/// Ground glass, ice and the like after Walter et al. 2007, as in Mitsuba 3. Microfacets reflect
/// light by the Fresnel term F and refract the rest. On wi's side,
///
///     f cos(theta_o) = specular_reflectance F(wi . h) D(h) G(wi, wo) / (4 cos(theta_i)).
///
/// On the other side, where eta is the index there divided by that on wi's side and h is along
/// wi + eta wo,
///
///     specular_transmittance (1 - F(wi . h)) D(h) G(wi, wo) |wi . h| |wo . h|
///                            / (cos(theta_i) (wi . h + eta wo . h)²).
///
/// This is the BSDF of radiance, which includes a factor 1 / eta². Two-sided: int_ior is the index
/// on the side that the normal points away from.
///
///     <bsdf type="roughdielectric">
///       <string name="distribution" value="ggx"/><float name="alpha" value="0.2"/>
///       <string name="int_ior" value="water ice"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {KINOME_ROUGH_DIELECTRIC_PARAMETERS};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RoughDielectric, kinome::Category::kBsdf, "roughdielectric",
              "Rough glass: microfacets that reflect and refract.", kinome::kParameters);
