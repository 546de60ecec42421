// Camera with parallel rays. The picture spans [-1, 1] in x of the camera's frame, and as much of y
// as its aspect ratio gives; to_world may scale it.
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

const Parameter kTable[] = {KINOME_CAMERA_PARAMETERS};

class Orthographic : public Sensor {
 public:
  explicit Orthographic(const Properties& props) : to_world_(read_camera_transform(props, true)) {
    check_shutter(props);
    film_ = read_part<Film>(props, "film");
    sampler_ = read_part<Sampler>(props, "sampler");
    plane_ = FilmPlane(*film_, 1.f);
    const ClipRange clip = read_clip_range(props);
    const Vec3 axis = to_world_.vector(Vec3(0, 0, 1));
    const float scale = glm::length(axis);
    direction_ = axis / scale;
    // As in Mitsuba, to_world scales the near plane's depth, and not the distance between both.
    near_ = clip.near * scale;
    far_ = near_ + (clip.far - clip.near);
  }

  Ray sample_ray(const Vec2& film_position, const Vec2&) const override {
    Ray ray;
    ray.o = to_world_.point(Vec3(plane_.at(film_position), 0.f));
    ray.d = direction_;
    ray.tmin = near_;
    ray.tmax = far_;
    return ray;
  }

 private:
  Transform to_world_;
  FilmPlane plane_;
  Vec3 direction_{0, 0, 1};
  float near_ = 0;
  float far_ = 0;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Orthographic, kinome::Category::kSensor, "orthographic",
              "Camera with parallel rays.", kinome::kTable);
