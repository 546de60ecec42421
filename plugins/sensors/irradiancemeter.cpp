// Mean irradiance of the shape in which it is nested: incident power per area. If the film has
// several pixels, they divide the unit square from which points of the shape are sampled.
//
//   <shape type="rectangle">
//     <sensor type="irradiancemeter">
//       <film type="hdrfilm"> <integer name="width" value="1"/> <integer name="height" value="1"/>
//         <rfilter type="box"/> </film>
//     </sensor>
//   </shape>

#include "kinome/error.h"
#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "meter.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SENSOR_PARAMETERS};

class IrradianceMeter final : public ParsedSensor {
 public:
  explicit IrradianceMeter(const Properties& props) : ParsedSensor(props) {
    // Directions are sampled with density cosine / pi.
    film_->set_response(kPi);
  }

  bool is_surface() const override { return true; }
  void attach(const Shape& shape) override {
    if (shape_) throw Error("an irradiancemeter must be nested in a single shape");
    shape_ = &shape;
  }
  bool needs_aperture_sample() const override { return true; }

  Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const override {
    const Vec2 size(film_->width(), film_->height());
    const Vec2 u = glm::clamp(film_position / size, Vec2(0.f), Vec2(kOneMinusEpsilon));
    const SurfaceInteraction si = shape_->sample_surface(u);
    const Vec3 d = si.frame.to_world(square_to_cosine_hemisphere(aperture));
    return {si.ray_origin(d), d};
  }

 private:
  const Shape* shape_ = nullptr;  ///< the enclosing shape; set by attach()
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::IrradianceMeter, kinome::Category::kSensor, "irradiancemeter",
              "Mean irradiance of the shape in which it is nested.", kinome::kTable);
