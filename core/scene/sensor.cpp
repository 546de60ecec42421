#include "kinome/sensor.h"

namespace kinome {
namespace {

/// Copy of a sensor with another sampler.
class ResampledSensor final : public Sensor {
 public:
  ResampledSensor(const Sensor& sensor, std::shared_ptr<Film> film,
                  std::shared_ptr<Sampler> sampler, std::shared_ptr<const Medium> medium)
      : sensor_(sensor) {
    medium_ = std::move(medium);
    film_ = std::move(film);
    sampler_ = std::move(sampler);
  }
  Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const override {
    return sensor_.sample_ray(film_position, aperture);
  }
  void sample_ray_block(const Columns2& film_position, const Columns2& aperture, size_t count,
                        RayHit16* out) const override {
    sensor_.sample_ray_block(film_position, aperture, count, out);
  }
  bool needs_aperture_sample() const override { return sensor_.needs_aperture_sample(); }
  std::optional<SensorConnection> connect(const Vec3& p, const Vec2& aperture) const override {
    return sensor_.connect(p, aperture);
  }
  void connect_block(const Columns3& p, const Columns2& aperture, size_t count,
                     const ConnectionBlock& out) const override {
    sensor_.connect_block(p, aperture, count, out);
  }

 private:
  const Sensor& sensor_;
};

}  // namespace

std::unique_ptr<Sensor> Sensor::with_sample_count(uint32_t count) const {
  return std::make_unique<ResampledSensor>(*this, film_, sampler_->with_sample_count(count), medium_);
}

}  // namespace kinome
