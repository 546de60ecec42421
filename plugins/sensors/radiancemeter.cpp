// Radiance along a single ray.
//
//   <sensor type="radiancemeter">
//     <point name="origin" x="0" y="1" z="5"/>
//     <vector name="direction" x="0" y="0" z="-1"/>
//     <film type="hdrfilm"> <integer name="width" value="1"/> <integer name="height" value="1"/>
//       <rfilter type="box"/> </film>
//   </sensor>

#include "kinome/plugin.h"
#include "meter.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"to_world", ParameterType::kTransform, "identity",
     "transform from sensor to world; the ray travels along +Z"},
    {"origin", ParameterType::kVector, nullptr, "origin of the ray; alternative to to_world"},
    {"direction", ParameterType::kVector, nullptr, "direction of the ray; alternative to to_world"},
    KINOME_SENSOR_PARAMETERS,
};

class RadianceMeter final : public ParsedSensor {
 public:
  explicit RadianceMeter(const Properties& props) : ParsedSensor(props) {
    check_film_of_one_pixel(props, *film_);
    if (props.has("origin") != props.has("direction")) {
      throw props.error(props.has("origin") ? "origin" : "direction",
                        "requires both origin and direction");
    }
    if (props.has("origin")) {
      if (props.has("to_world")) {
        throw props.error("to_world",
                          "can't be combined with 'origin' and 'direction'");
      }
      ray_.o = props.vector("origin");
      ray_.d = read_direction(props, "direction");
    } else {
      const Transform to_world = read_camera_transform(props, true);
      ray_.o = to_world.point(Vec3(0.f));
      ray_.d = glm::normalize(to_world.vector(Vec3(0, 0, 1)));
    }
  }

  Ray sample_ray(const Vec2&, const Vec2&) const override { return ray_; }

 private:
  Ray ray_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RadianceMeter, kinome::Category::kSensor, "radiancemeter",
              "Radiance along a single ray.", kinome::kTable);
