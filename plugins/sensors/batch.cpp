// Pictures of several sensors, side by side on one film. As in Mitsuba, what a sensor's own film
// says counts for its field of view alone, and its sampler for nothing.
//
//   <sensor type="batch">
//     <sensor type="perspective"> … </sensor>
//     <sensor type="perspective"> … </sensor>
//     <film type="hdrfilm"> <integer name="width" value="512"/> … </film>
//   </sensor>

#include <algorithm>
#include <vector>

#include "kinome/plugin.h"
#include "meter.h"

namespace kinome {
namespace {

constexpr int kMostSensors = 4096;

const Parameter kTable[] = {
    {"sensor", ParameterType::kObject, nullptr, "one for each part of the picture, from the left",
     true, Category::kSensor, kMostSensors},
    ignored_row("to_world", ParameterType::kTransform, "each nested sensor has its own"),
    KINOME_SENSOR_PARAMETERS,
};

class Batch final : public Sensor {
 public:
  explicit Batch(const Properties& props) : sensors_(props.objects<Sensor>()) {
    shutter_ = read_shutter(props);
    film_ = read_part<Film>(props, "film");
    sampler_ = read_part<Sampler>(props, "sampler");
    const auto count = static_cast<int>(sensors_.size());
    if (film_->width() % count != 0) {
      throw props.error("film", "must have a width that its " + std::to_string(count) +
                                    " sensors divide, got " + std::to_string(film_->width()));
    }
    part_ = Vec2(film_->width() / count, film_->height());
    for (const auto& sensor : sensors_) {
      if (sensor->is_surface()) {
        throw props.error("sensor", "can't be one that must be part of a shape");
      }
      const Vec2 size(sensor->film().width(), sensor->film().height());
      // Of its picture as wide as the part, the height that it has there.
      scale_.emplace_back(size.x / part_.x, size.x / part_.x);
      centre_.push_back(0.5f * size);
    }
  }

  void set_scene_bounds(const Aabb& bounds) override {
    for (const auto& sensor : sensors_) sensor->set_scene_bounds(bounds);
  }

  bool needs_aperture_sample() const override {
    return std::any_of(sensors_.begin(), sensors_.end(),
                       [](const auto& sensor) { return sensor->needs_aperture_sample(); });
  }

  Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const override {
    const int last = static_cast<int>(sensors_.size()) - 1;
    const int index = std::clamp(static_cast<int>(std::floor(film_position.x / part_.x)), 0, last);
    const auto i = static_cast<size_t>(index);
    const Vec2 within = film_position - Vec2(static_cast<float>(index) * part_.x, 0.f);
    return sensors_[i]->sample_ray(centre_[i] + (within - 0.5f * part_) * scale_[i], aperture);
  }

 private:
  std::vector<std::shared_ptr<Sensor>> sensors_;
  std::vector<Vec2> scale_;   ///< of a pixel of the part, in pixels of the sensor's film
  std::vector<Vec2> centre_;  ///< of the sensors' films
  Vec2 part_{1.f};            ///< of the film, for one sensor
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Batch, kinome::Category::kSensor, "batch",
              "Pictures of several sensors, side by side.", kinome::kTable);
