// A pinhole camera at the origin that looks along +z, with 90 degrees across the width, except for
// its fault.

#include "kinome/sensor.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {
    KINOME_WRONG_PARAMETER,
    {"film", ParameterType::kObject, nullptr, "Its film.", false, Category::kFilm},
    {"sampler", ParameterType::kObject, nullptr, "Its sampler.", false, Category::kSampler},
};

class WrongPinhole final : public Sensor {
 public:
  explicit WrongPinhole(const Properties& props) : wrong_(props) {
    film_ = props.object<Film>();
    sampler_ = props.object<Sampler>();
    pixel_ = 2 / static_cast<float>(film_->width());
    centre_ = 0.5f * Vec2(film_->width(), film_->height());
  }

  Ray sample_ray(const Vec2& film_position, const Vec2& /*aperture*/) const override {
    const Vec2 p = (centre_ - film_position) * pixel_;
    Ray ray;
    ray.d = glm::normalize(Vec3(p, 1)) * wrong_.or_wrong("length", 1.f, 1.01f);
    return ray;
  }
  std::optional<SensorConnection> connect(const Vec3& p, const Vec2& /*aperture*/) const override {
    if (!(p.z > 0)) return std::nullopt;
    SensorConnection seen;
    const float mirror = wrong_.or_wrong("mirror", 1.f, -1.f);
    seen.film_position = centre_ - Vec2(mirror * p.x, p.y) / (p.z * pixel_);
    seen.distance = glm::length(p);
    seen.d = -p / seen.distance;
    // A pixel's solid angle is its area at a distance of 1 times cos³.
    const float cosine = wrong_.is("cosine") ? 1 : p.z / seen.distance;
    seen.weight = wrong_.or_wrong("weight", 1.f, 2.f) /
                  (pixel_ * pixel_ * cosine * cosine * cosine * seen.distance * seen.distance);
    const Rect sampled = film_->sampled();
    const bool is_on_film = seen.film_position.x >= static_cast<float>(sampled.x0) &&
                            seen.film_position.x < static_cast<float>(sampled.x1) &&
                            seen.film_position.y >= static_cast<float>(sampled.y0) &&
                            seen.film_position.y < static_cast<float>(sampled.y1);
    if (!is_on_film) return std::nullopt;
    return seen;
  }
  void connect_block(const Columns3& p, const Columns2& aperture, size_t count,
                     const ConnectionBlock& out) const override {
    Sensor::connect_block(p, aperture, count, out);
    for (size_t i = 0; wrong_.is("block") && i < count; ++i) out.weight[i] *= 1.1f;
  }

 private:
  Wrong wrong_;
  float pixel_ = 0;  ///< side of a pixel at a distance of 1
  Vec2 centre_{0.f};
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongPinhole, kinome::Category::kSensor, "wrong", "Has a fault.",
              kinome::test::kTable);
