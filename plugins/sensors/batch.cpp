// Images of several sensors, side by side on one film. As in Mitsuba, the film of a nested sensor
// only affects its field of view, and its sampler is ignored.
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

constexpr int kMaxSensors = 4096;

const Parameter kTable[] = {
    {"sensor", ParameterType::kObject, nullptr, "sensors of the image's parts, from left to right",
     true, Category::kSensor, kMaxSensors},
    ignored_row("to_world", ParameterType::kTransform, "each nested sensor has its own"),
    KINOME_SENSOR_PARAMETERS,
};

class Batch final : public ParsedSensor {
 public:
  explicit Batch(const Properties& props) : ParsedSensor(props), sensors_(props.objects<Sensor>()) {
    const auto count = static_cast<int>(sensors_.size());
    if (film_->width() % count != 0) {
      throw props.error("film", "must have a width that is a multiple of " + std::to_string(count) +
                                    ", the number of sensors, got " +
                                    std::to_string(film_->width()));
    }
    part_ = Vec2(film_->width() / count, film_->height());
    for (const auto& sensor : sensors_) {
      if (sensor->is_surface()) {
        throw props.error("sensor", "must not be of a kind that must be nested in a shape");
      }
      const Vec2 size(sensor->film().width(), sensor->film().height());
      // Scales the sensor's image to the width of the part.
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
  std::vector<Vec2> scale_;   ///< size of a pixel of the part, in pixels of the sensor's film
  std::vector<Vec2> centre_;  ///< centres of the sensors' films
  Vec2 part_{1.f};            ///< size of one sensor's part of the film
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Batch, kinome::Category::kSensor, "batch",
              "Images of several sensors, side by side on one film.", kinome::kTable);
