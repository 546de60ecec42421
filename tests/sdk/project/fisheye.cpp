// A camera with a field of view of up to 360 degrees: distances from the image's centre are angles
// from the axis.
//
//     <sensor type="fisheye"> <float name="fov" value="180"/> </sensor>

#include <algorithm>
#include <cmath>

#include <kinome/plugin.h>
#include <kinome/sensor.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"to_world", ParameterType::kTransform, "identity", "Camera to world; looks along +Z."},
    {"fov", ParameterType::kFloat, "180", "Degrees across the image's shorter side, to 360."},
    {"film", ParameterType::kObject, nullptr, "Its film.", false, Category::kFilm},
    {"sampler", ParameterType::kObject, nullptr, "Its sampler.", false, Category::kSampler},
};

class Fisheye final : public Sensor {
 public:
  explicit Fisheye(const Properties& props) : to_world_(props.transform("to_world")) {
    const float fov = props.real("fov");
    if (!(fov > 0 && fov <= 360)) {
      throw props.error("fov", "must lie in (0, 360], got " + std::to_string(fov));
    }
    // If the scene has none, these are the defaults of all sensors.
    film_ = props.object<Film>();
    sampler_ = props.object<Sampler>();
    const auto side = static_cast<float>(std::min(film_->width(), film_->height()));
    angle_per_pixel_ = fov * kPi / (180 * side);
    centre_ = 0.5f * Vec2(film_->width(), film_->height());
  }

  // In the camera's frame, +X points to the left of the image and +Y up.
  Ray sample_ray(const Vec2& film_position, const Vec2& /*aperture*/) const override {
    const Vec2 p = film_position - centre_;
    const float r = glm::length(p);
    const float angle = std::min(r * angle_per_pixel_, kPi);
    const float across = r > 0 ? -std::sin(angle) / r : 0.f;
    Ray ray;
    ray.o = to_world_.point(Vec3(0.f));
    ray.d = glm::normalize(to_world_.vector(Vec3(p.x * across, p.y * across, std::cos(angle))));
    ray.tmin = 1e-3f;
    return ray;
  }

 private:
  Transform to_world_;
  float angle_per_pixel_ = 0;
  Vec2 centre_{0.f};
};

}  // namespace

KINOME_PLUGIN(Fisheye, Category::kSensor, "fisheye", "A camera of up to 360 degrees.", kParameters);
