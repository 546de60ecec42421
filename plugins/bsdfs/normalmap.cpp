#include "kinome/plugin.h"
#include "turned_frame.h"

/// Perturbs the shading frame of a nested BSDF by a texture of normals, stored as (n + 1) / 2 in
/// the shading frame, as in Mitsuba 3; see turned_frame.h. The texture must be `raw`; otherwise its
/// values are decoded as sRGB.
///
///     <bsdf type="normalmap">
///       <texture name="normalmap" type="bitmap">
///         <string name="filename" value="normals.png"/><boolean name="raw" value="true"/>
///       </texture>
///       <bsdf type="roughplastic"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"normalmap", ParameterType::kUnitlessTexture, nullptr, "normals as colours (n + 1) / 2",
     true},
    KINOME_TURNED_FRAME_PARAMETERS,
};

class NormalMap final : public TurnedFrame<NormalMap> {
 public:
  explicit NormalMap(const Properties& props)
      : TurnedFrame(props), normals_(props.texture("normalmap")) {}

  TurnedAxes<float> axes_at(const SurfaceInteraction& si) const {
    return axes<float>(normals_.at(si));
  }
  template <class Fn>
  void with_axes(const SurfaceBlock& points, const Fn& fn) const {
    const ColorInput::Columns texels(normals_, points);
    fn([&](size_t i, const FrameOf<wide::Vec3>& /*frame*/) { return axes<wide::Float>(texels[i]); });
  }

 private:
  /// A texel of middle grey gives the zero vector, which leaves the frame as it is.
  template <class F>
  static TurnedAxes<F> axes(const RgbOf<F>& texel) {
    return {2.f * texel - VecOf<F>(1.f), VecOf<F>(1.f, 0.f, 0.f)};
  }

  ColorInput normals_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::NormalMap, kinome::Category::kBsdf, "normalmap",
              "Perturbs the shading frame of a nested BSDF by a texture of normals.",
              kinome::kParameters);
