// Pinhole camera.
//
//   <sensor type="perspective">
//     <float name="fov" value="40"/>
//     <transform name="to_world"><lookat origin="0 1 5" target="0 1 0" up="0 1 0"/></transform>
//     <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
//     <film type="hdrfilm"/>
//   </sensor>

#include "camera.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    KINOME_CAMERA_PARAMETERS,
    KINOME_FOV_PARAMETERS,
    {"principal_point_offset_x", ParameterType::kFloat, "0",
     "horizontal offset of the image's centre, in units of the width"},
    {"principal_point_offset_y", ParameterType::kFloat, "0",
     "vertical offset of the image's centre, in units of the height"},
    ignored_row("focus_distance", ParameterType::kFloat, "a pinhole camera is sharp everywhere"),
};

class Perspective final : public FormulaSensor<Perspective> {
 public:
  explicit Perspective(const Properties& props)
      : FormulaSensor(props, false), clip_(read_clip_range(props)) {
    const Vec2 offset(props.real("principal_point_offset_x"),
                      props.real("principal_point_offset_y"));
    plane_ = FilmPlane(*film_, read_half_width(props, aspect_ratio(*film_)), offset);
    origin_ = to_world_.point(Vec3(0.f));
  }

  template <class F>
  CameraRay<F> ray(const wide::Vec2Of<F>& film_position, const wide::Vec2Of<F>&) const {
    using namespace wide::formulas;
    const auto p = plane_.at(film_position);
    const F length = sqrt(p.x * p.x + p.y * p.y + 1.f);
    return {VecOf<F>(origin_), normalize(transform_vector(to_world_, VecOf<F>(p.x, p.y, F(1.f)))),
            clip_.near * length, clip_.far * length};
  }

  template <class F>
  Connection<F> connection(const wide::VecOf<F>& p, const wide::Vec2Of<F>&) const {
    using namespace wide::formulas;
    const VecOf<F> local = transform_point(to_camera_, p);
    return connect_to_lens(local, VecOf<F>(F(0.f)),
                           Vec2Of<F>(local.x / local.z, local.y / local.z), plane_, clip_,
                           *film_, to_world_);
  }

 private:
  ClipRange clip_;
  Vec3 origin_;
  FilmPlane plane_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Perspective, kinome::Category::kSensor, "perspective", "Pinhole camera.",
              kinome::kTable);
