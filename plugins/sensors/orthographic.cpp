// Camera with parallel rays. The image spans [-1, 1] in x of the camera's frame; its extent in y
// follows from the aspect ratio. to_world may scale it.
//
//   <sensor type="orthographic">
//     <transform name="to_world">
//       <scale value="10"/>
//       <lookat origin="0 20 0" target="0 0 0" up="0 0 1"/>
//     </transform>
//   </sensor>

#include "camera.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    KINOME_CAMERA_PARAMETERS,
    ignored_row("focus_distance", ParameterType::kFloat, "parallel rays are sharp everywhere"),
};

class Orthographic final : public FormulaSensor<Orthographic> {
 public:
  explicit Orthographic(const Properties& props) : FormulaSensor(props, true) {
    plane_ = FilmPlane(*film_, 1.f);
    const ClipRange clip = read_clip_range(props);
    const Vec3 axis = to_world_.vector(Vec3(0, 0, 1));
    scale_ = glm::length(axis);
    direction_ = axis / scale_;
    // The area perpendicular to the rays, because to_world may shear the image plane.
    const Vec3 x = to_world_.vector(Vec3(1, 0, 0)), y = to_world_.vector(Vec3(0, 1, 0));
    inverse_pixel_area_ =
        1 / (plane_.pixel_area() * std::abs(glm::dot(glm::cross(x, y), direction_)));
    // As in Mitsuba, to_world scales the depth of the near plane, but not the distance between both
    // planes.
    near_ = clip.near * scale_;
    far_ = near_ + (clip.far - clip.near);
  }

  template <class F>
  CameraRay<F> ray(const wide::Vec2Of<F>& film_position, const wide::Vec2Of<F>&) const {
    using wide::VecOf;
    const auto p = plane_.at(film_position);
    return {transform_point(to_world_, VecOf<F>(p.x, p.y, F(0.f))), VecOf<F>(direction_), F(near_),
            F(far_)};
  }

  template <class F>
  Connection<F> connection(const wide::VecOf<F>& p, const wide::Vec2Of<F>&) const {
    using namespace wide::formulas;
    const VecOf<F> local = transform_point(to_camera_, p);
    const F distance = local.z * scale_;
    const auto film_position = plane_.film_position(Vec2Of<F>(local.x, local.y));
    return {film_position, VecOf<F>(-direction_), distance - near_, F(inverse_pixel_area_),
            distance >= near_ && distance <= far_ && contains(film_->sampled(), film_position)};
  }

 private:
  FilmPlane plane_;
  Vec3 direction_{0, 0, 1};
  float scale_ = 1;  ///< length of a unit of depth in the world
  float inverse_pixel_area_ = 1;
  float near_ = 0;
  float far_ = 0;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Orthographic, kinome::Category::kSensor, "orthographic",
              "Camera with parallel rays.", kinome::kTable);
