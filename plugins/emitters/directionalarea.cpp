/// A surface that emits light only along its normal, like the front of a laser. In spite of its
/// name, `radiance` is the flux per area of the surface [W/m²]. The direction can't be hit by rays
/// or sampled from a point: as in Mitsuba, only `ptracer` renders this light, and other integrators
/// see a black surface.
///
///     <shape type="disk">
///       <emitter type="directionalarea"><rgb name="radiance" value="5 4 3"/></emitter>
///     </shape>

#include "emission.h"
#include "kinome/emitter.h"
#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/wide/textures.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"radiance", ParameterType::kEmissionTexture, "1",
     "Flux per area [W/m²], textured over the shape's (u, v)."},
};

class DirectionalAreaLight final : public Emitter {
 public:
  explicit DirectionalAreaLight(const Properties& props)
      : flux_(read_emission_texture(props, "radiance")) {}

  bool is_surface() const override { return true; }

  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& /*u*/) const override {
    return std::nullopt;
  }

  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& /*direction*/) const override {
    const float area = shape()->area();
    const SurfaceInteraction si = shape()->sample_surface(position);
    const Rgb flux = flux_.at(si);
    if (!(area > 0) || is_black(flux)) return std::nullopt;
    EmissionSample sample;
    sample.o = si.p;
    sample.o_error = si.p_error;
    sample.n = si.n;
    sample.d = si.frame.n;
    sample.power = flux * area;
    return sample;
  }

 private:
  wide::ColorInput flux_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::DirectionalAreaLight, kinome::Category::kEmitter, "directionalarea",
              "A surface that emits light only along its normal.", kinome::kTable);
