#include "kinome/bsdf_medium.h"
#include "kinome/plugin.h"
#include "kinome/wide/phase.h"
#include "rough_dielectric.h"

/// Wax, marble, milk, skin and the like: a rough dielectric boundary, and behind it a homogeneous
/// medium that is given by its look. The medium is the interior of the shapes with this BSDF, which
/// must be closed and can't have another one. `volpath` and `clustered` render it exactly, by walks
/// of the light inside; integrators without media show rough glass.
///
/// `color` is the albedo of a deep, flat body in uniform light, apart from the reflections at its
/// boundary, as the `diffuse_reflectance` of `roughplastic`. `radius` is the mean free path in
/// units of the scene; that of red light is the longest in most bodies. The extinction of the
/// medium is 1 / (scale radius). The albedo of single collisions is, after Kulla and Conty 2017,
/// "Revisiting Physically Based Shading at Imageworks",
///
///     (1 - s²) / (1 - g s²),
///     s = 4.09712 + 4.20863 color - sqrt(9.59217 + 41.6808 color + 17.7126 color²).
///
/// The fit is accurate to 0.005 for g = 0.
///
///     <bsdf type="subsurface">
///       <rgb name="color" value="0.9 0.75 0.5"/><rgb name="radius" value="0.1 0.05 0.02"/>
///       <float name="alpha" value="0.3"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"color", ParameterType::kReflectanceTexture, "0.5",
     "albedo of a deep body, without the reflections of its boundary; must be uniform"},
    {"radius", ParameterType::kUnitlessTexture, "1",
     "mean free path inside, in units of the scene; must be uniform"},
    {"scale", ParameterType::kFloat, "1", "scale factor of the radius"},
    {"g", ParameterType::kFloat, "0",
     "mean cosine of the deflection at a collision, between -1 and 1; positive values scatter "
     "forward"},
    KINOME_ROUGH_DIELECTRIC_PARAMETERS,
};

/// Largest extinction: far beyond the resolution of distances, but finite in all formulas.
constexpr float kMaxExtinction = 1e9f;

/// Returns the albedo of single collisions of a body of the given color.
float albedo_of_collisions(float color, float g) {
  const float s = 4.09712f + 4.20863f * color -
                  std::sqrt(9.59217f + 41.6808f * color + 17.7126f * color * color);
  const float s2 = sqr(std::clamp(s, 0.f, 1.f));
  return (1 - s2) / (1 - g * s2);
}

Rgb uniform_color(const Properties& props, const char* name, std::shared_ptr<Texture> texture) {
  if (!texture->is_uniform()) throw props.error(name, "must be uniform, got a texture");
  return texture->mean();
}

/// Homogeneous medium with the given coefficients.
class Body final : public Medium {
 public:
  Body(const Rgb& extinction, const Rgb& albedo, float g) : at_{extinction, extinction * albedo} {
    phase_ = std::make_shared<wide::HenyeyGreensteinPhase>(g);
    is_coloured_ = extinction.x != extinction.y || extinction.y != extinction.z;
    min_extinction_ = -max_component(-extinction);
    max_extinction_ = max_component(extinction);
  }

  MediumCoefficients coefficients(const Vec3& /*p*/, const Vec3& /*d*/) const override {
    return at_;
  }
  bool is_uniform() const override { return true; }

 private:
  MediumCoefficients at_;
};

std::shared_ptr<const Medium> make_body(const Properties& props) {
  const Rgb color = uniform_color(props, "color", reflectance_texture(props, "color"));
  const Rgb radius = uniform_color(props, "radius", nonnegative_texture(props, "radius"));
  const float scale =
      props.real("scale", "must be positive", [](float s) { return s > 0 && std::isfinite(s); });
  const float g = props.real("g", "must be greater than -1 and less than 1",
                             [](float v) { return std::abs(v) < 1; });
  Rgb extinction, albedo;
  for (int c = 0; c < 3; ++c) {
    extinction[c] = 1 / (scale * radius[c]);
    if (!(extinction[c] < kMaxExtinction)) {
      throw props.error(
          "radius", "must be at least 1e-9 after scaling, got " + format_number(scale * radius[c]));
    }
    albedo[c] = albedo_of_collisions(color[c], g);
  }
  return std::make_shared<Body>(extinction, albedo, g);
}

class Subsurface final : public RoughDielectric, public InteriorMedium {
 public:
  explicit Subsurface(const Properties& props)
      : RoughDielectric(props), interior_(make_body(props)) {}

  std::shared_ptr<const Medium> interior() const override { return interior_; }

 private:
  std::shared_ptr<const Medium> interior_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(
    kinome::Subsurface, kinome::Category::kBsdf, "subsurface",
    "Wax, marble, milk or skin: a rough boundary around a medium that is given by its color.",
    kinome::kParameters);
