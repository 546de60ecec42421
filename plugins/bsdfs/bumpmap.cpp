#include "kinome/plugin.h"
#include "turned_frame.h"

/// Turns the shading frame of a nested BSDF as if a texture of heights had displaced the surface
/// along its normal, as in Mitsuba 3; see turned_frame.h. Heights are in units of the scene; only
/// their slopes count (Blinn 1978, "Simulation of Wrinkled Surfaces", without the term of the
/// surface's own curvature). The texture should be `raw`, or its numbers are taken for sRGB colours.
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
    {"texture", ParameterType::kObject, nullptr, "the heights, read as one number", true,
     Category::kTexture},
    {"scale", ParameterType::kFloat, "1", "factor of the heights"},
    KINOME_TURNED_FRAME_PARAMETERS,
};

class BumpMap final : public TurnedFrame<BumpMap> {
 public:
  explicit BumpMap(const Properties& props)
      : TurnedFrame(props), heights_(props.object<Texture>()), scale_(props.real("scale")) {
    if (!heights_->attribute().empty()) {
      throw props.error("texture", "has no slopes: of a mesh's attribute only values are known");
    }
    if (!std::isfinite(scale_)) {
      throw props.error("scale", "must be finite, got " + std::to_string(scale_));
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
    // In the plane of the shading frame, and up by the slopes.
    const VecOf<F> n = cross(VecOf<F>(along_u.x, along_u.y, scale_ * slope.x),
                             VecOf<F>(along_v.x, along_v.y, scale_ * slope.y));
    // Of a mirrored (u, v), the product points inward.
    const auto is_outward = dot(n, frame.to_local(geometric_normal)) >= 0.f;
    // Mitsuba 3.9.1 takes dp_du, in world coordinates, for one in those of the frame. Anisotropic
    // BSDFs, which alone show it, are to look as they do there.
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
