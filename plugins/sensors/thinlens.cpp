// Camera with a thin lens: points at the depth `focus_distance` are in focus.
//
//   <sensor type="thinlens">
//     <float name="fov" value="40"/>
//     <float name="aperture_radius" value="0.05"/>
//     <float name="focus_distance" value="5"/>
//   </sensor>

#include "camera.h"
#include "kinome/plugin.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    KINOME_CAMERA_PARAMETERS,
    KINOME_FOV_PARAMETERS,
    {"aperture_radius", ParameterType::kFloat, nullptr, "radius of the lens, in scene units", true},
    {"focus_distance", ParameterType::kFloat, nullptr,
     "depth of the plane in focus; default: far_clip"},
};

class ThinLens final : public FormulaSensor<ThinLens> {
 public:
  explicit ThinLens(const Properties& props)
      : FormulaSensor(props, false), clip_(read_clip_range(props)) {
    plane_ = FilmPlane(*film_, read_half_width(props, aspect_ratio(*film_)));
    aperture_radius_ = read_positive(props, "aperture_radius");
    focus_distance_ =
        props.has("focus_distance") ? read_positive(props, "focus_distance") : clip_.far;
  }

  template <class F>
  CameraRay<F> ray(const wide::Vec2Of<F>& film_position, const wide::Vec2Of<F>& aperture) const {
    using namespace wide::formulas;
    const auto lens = aperture_radius_ * warp::square_to_disk_concentric(aperture);
    const auto sharp = focus_distance_ * plane_.at(film_position);
    const VecOf<F> d = normalize(VecOf<F>(sharp.x - lens.x, sharp.y - lens.y, F(focus_distance_)));
    return {transform_point(to_world_, VecOf<F>(lens.x, lens.y, F(0.f))),
            normalize(transform_vector(to_world_, d)), clip_.near / d.z, clip_.far / d.z};
  }
  bool needs_aperture_sample() const override { return true; }

  template <class F>
  Connection<F> connection(const wide::VecOf<F>& p, const wide::Vec2Of<F>& aperture) const {
    using namespace wide::formulas;
    using V2 = Vec2Of<F>;
    const VecOf<F> local = transform_point(to_camera_, p);
    const V2 lens = aperture_radius_ * warp::square_to_disk_concentric(aperture);
    // The intersection with depth 1 of the ray from the lens's centre to the same point in focus.
    const V2 on_plane = (V2(local.x, local.y) - lens) / local.z + lens / focus_distance_;
    return connect_to_lens(local, VecOf<F>(lens.x, lens.y, F(0.f)), on_plane, plane_, clip_, *film_,
                           to_world_);
  }

 private:
  ClipRange clip_;
  FilmPlane plane_;
  float aperture_radius_ = 0;
  float focus_distance_ = 0;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::ThinLens, kinome::Category::kSensor, "thinlens",
              "Camera with a thin lens: depth of field.", kinome::kTable);
