// Mean radiance that leaves the scene in one direction: over the cross section of the scene's
// bounding sphere, at one point, or over a shape that isn't part of the scene.
//
//   <sensor type="distant">
//     <vector name="direction" x="0" y="0" z="-1"/>
//     <shape type="rectangle" name="target"/>
//     <film type="hdrfilm"> <integer name="width" value="1"/> <integer name="height" value="1"/>
//       <rfilter type="box"/> </film>
//   </sensor>

#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "meter.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"to_world", ParameterType::kTransform, "identity",
     "transform from sensor to world; rays travel along +Z"},
    {"direction", ParameterType::kVector, nullptr,
     "direction in which rays travel; alternative to to_world"},
    {"target", ParameterType::kVector, nullptr,
     "point that all rays go through; alternative to the nested shape"},
    {"shape", ParameterType::kObject, nullptr,
     "shape that rays go through, uniformly over its area", false, Category::kShape},
    KINOME_SENSOR_PARAMETERS,
};

class Distant final : public ParsedSensor {
 public:
  explicit Distant(const Properties& props) : ParsedSensor(props), shape_(props.object<Shape>()) {
    check_film_of_one_pixel(props, *film_);
    if (props.has("direction")) {
      props.exclude("direction", "to_world");
      frame_ = Frame::from_normal(read_direction(props, "direction"));
    } else {
      const Transform to_world = read_camera_transform(props, true);
      frame_ = Frame::from_normal(glm::normalize(to_world.vector(Vec3(0, 0, 1))));
    }
    // The shape may be named target, too. A point in addition to it isn't read, and thus an error.
    if (!shape_ && props.has("target")) target_ = props.vector("target");
  }

  void set_scene_bounds(const Aabb& bounds) override {
    if (bounds.empty()) return;
    centre_ = bounds.centre();
    radius_ = 0.5f * glm::length(bounds.extent());
  }

  bool needs_aperture_sample() const override { return true; }

  Ray sample_ray(const Vec2&, const Vec2& aperture) const override {
    const Vec3& d = frame_.n;
    if (shape_ || target_) {
      const Vec3 target = shape_ ? shape_->sample_surface(aperture).p : *target_;
      return {target - d * (2 * radius_), d};  // outside the scene if the target is inside
    }
    const Vec2 p = square_to_disk_concentric(aperture) * radius_;
    return {centre_ + frame_.s * p.x + frame_.t * p.y - d * radius_, d};
  }

 private:
  Frame frame_;
  std::shared_ptr<Shape> shape_;
  std::optional<Vec3> target_;
  Vec3 centre_{0.f};  ///< centre of the scene's bounding sphere
  float radius_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Distant, kinome::Category::kSensor, "distant",
              "Mean radiance that leaves the scene in one direction.", kinome::kTable);
