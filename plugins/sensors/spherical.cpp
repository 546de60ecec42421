// Camera that sees all directions, as in Mitsuba 0.6. The image is a latitude-longitude map such as
// `envmap` reads: its top row is +Y and its centre is +Z of the camera's frame.
//
//   <sensor type="spherical">
//     <transform name="to_world"><translate y="1.5"/></transform>
//     <film type="hdrfilm"> <integer name="width" value="512"/>
//       <integer name="height" value="256"/> </film>
//   </sensor>

#include "kinome/plugin.h"
#include "kinome/wide/functions.h"
#include "meter.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"to_world", ParameterType::kTransform, "identity", "transform from camera to world"},
    KINOME_SENSOR_PARAMETERS,
};

class Spherical final : public FormulaSensor<Spherical> {
 public:
  explicit Spherical(const Properties& props) : FormulaSensor(props, false) {
    step_ = Vec2(2 * kPi / static_cast<float>(film_->width()),
                 kPi / static_cast<float>(film_->height()));
  }

  template <class F>
  CameraRay<F> ray(const wide::Vec2Of<F>& film_position, const wide::Vec2Of<F>&) const {
    using namespace wide::formulas;
    const F phi = film_position.x * step_.x, theta = film_position.y * step_.y;
    const F sine = sin(theta);
    const VecOf<F> d(sin(phi) * sine, cos(theta), -cos(phi) * sine);
    return {transform_point(to_world_, VecOf<F>(F(0.f), F(0.f), F(0.f))),
            transform_vector(to_world_, d), F(0.f), F(kInfinity)};
  }

  template <class F>
  Connection<F> connection(const wide::VecOf<F>& p, const wide::Vec2Of<F>&) const {
    using namespace wide::formulas;
    constexpr float kMinSine = 1e-6f;
    const VecOf<F> local = transform_point(to_camera_, p);
    const F distance2 = dot(local, local), distance = sqrt(distance2);
    const VecOf<F> d = local / max(distance, F(1e-30f));
    const F angle = atan2(d.x, -d.z);
    const Vec2Of<F> position(select(angle < 0.f, angle + 2 * kPi, angle) / step_.x,
                             acos(clamp(d.y, F(-1.f), F(1.f))) / step_.y);
    const F sine = max(sqrt(max(1.f - d.y * d.y, F(0.f))), F(kMinSine));
    return {position, transform_vector(to_world_, -d), distance,
            1.f / (step_.x * step_.y * sine * distance2),
            distance2 > 0.f && contains(film_->sampled(), position)};
  }

 private:
  Vec2 step_{1.f};  ///< angles that a pixel spans
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Spherical, kinome::Category::kSensor, "spherical",
              "Camera that sees all directions, as in Mitsuba 0.6.", kinome::kTable);
