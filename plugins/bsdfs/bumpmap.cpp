#include "kinome/plugin.h"
#include "turned_frame.h"

/// Perturbs the shading frame of a nested BSDF as if a texture of heights had displaced the surface
/// along its normal, as in Mitsuba 3; see turned_frame.h. Heights are in units of the scene; only
/// their slopes matter (Blinn 1978, "Simulation of Wrinkled Surfaces", without the term of the
/// surface's own curvature). The texture should be `raw`; otherwise its values are decoded as sRGB.
///
///     <bsdf type="bumpmap">
///       <texture type="bitmap">
///         <string name="filename" value="heights.png"/><boolean name="raw" value="true"/>
///       </texture>
///       <float name="scale" value="0.1"/>
///       <bsdf type="roughplastic"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"texture", ParameterType::kObject, nullptr, "heights, read as a single channel", true,
     Category::kTexture},
    {"scale", ParameterType::kFloat, "1", "scale factor of the heights"},
    KINOME_TURNED_FRAME_PARAMETERS,
};

class BumpMap final : public TurnedFrame<BumpMap> {
 public:
  explicit BumpMap(const Properties& props)
      : TurnedFrame(props),
        heights_(props.object<Texture>("texture")),
        scale_(props.real("scale", "must be finite", [](float s) { return std::isfinite(s); })) {
    if (!heights_->attribute().empty()) {
      throw props.error("texture", "can't be a mesh attribute, which has no derivatives");
    }
  }

  TurnedAxes<float> axes_at(const SurfaceInteraction& si) const {
    return axes<float>(si.frame, si.n, si.dp_du, si.dp_dv, heights_->eval_1_gradient(si.uv));
  }
  template <class Fn>
  void with_axes(const SurfaceBlock& points, const Fn& fn) const {
    const wide::ScratchColumns columns(2, points.count);
    const Columns2 slopes = columns.two();
    heights_->eval_1_gradient_block(points.uv, points.count, slopes);
    fn([&](size_t i, const FrameOf<wide::Vec3>& frame) {
      const auto along = [&](const Columns3& columns_of, const wide::Vec3& axis) {
        return columns_of.x ? wide::Vec3::load(columns_of, i) : axis;
      };
      return axes<wide::Float>(frame, wide::Vec3::load(points.n, i), along(points.dp_du, frame.s),
                               along(points.dp_dv, frame.t), wide::Vec2::load(slopes, i));
    });
  }

 private:
  template <class F>
  TurnedAxes<F> axes(const FrameOf<VecOf<F>>& frame, const VecOf<F>& geometric_normal,
                     const VecOf<F>& dp_du, const VecOf<F>& dp_dv, const Vec2Of<F>& slope) const {
    const VecOf<F> along_u = frame.to_local(dp_du), along_v = frame.to_local(dp_dv);
    // The tangents of the displaced surface: dp_du and dp_dv in the plane of the shading frame,
    // with the slopes as z.
    const VecOf<F> n = cross(VecOf<F>(along_u.x, along_u.y, scale_ * slope.x),
                             VecOf<F>(along_v.x, along_v.y, scale_ * slope.y));
    // The product points inward if (u, v) is mirrored.
    const auto is_outward = dot(n, frame.to_local(geometric_normal)) >= 0.f;
    // Mitsuba 3.9.1 uses dp_du, which is in world coordinates, as if it were in the frame's. This
    // copies it, so that anisotropic BSDFs look the same; others don't depend on it.
    return {select(is_outward, n, -n), dp_du};
  }

  std::shared_ptr<const Texture> heights_;
  float scale_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::BumpMap, kinome::Category::kBsdf, "bumpmap",
              "Perturbs the shading frame of a nested BSDF by a texture of heights.",
              kinome::kParameters);
