#include "session/preview_sensor.h"

#include <array>
#include "kinome/image_files.h"

namespace kinome::viewer {
namespace {

class OnePixelFilter final : public ReconstructionFilter {
 public:
  float eval(float x) const override { return x >= -radius() && x < radius() ? 1.f : 0.f; }
};

class PreviewFilm final : public Film {
 public:
  PreviewFilm(const Film& film, int width, int height, bool has_box_filter) {
    width_ = width;
    height_ = height;
    crop_ = {0, 0, width, height};
    sample_border_ = film.sample_border();
    has_alpha_ = film.has_alpha();
    if (has_box_filter) {
      filter_ = std::make_shared<OnePixelFilter>();
      return;
    }
    // Shares the filter without owning it. The cast is safe because filters are never changed.
    filter_ = std::shared_ptr<ReconstructionFilter>(
        std::shared_ptr<void>(), const_cast<ReconstructionFilter*>(&film.filter()));
  }
  void write(const std::string& path, const Image& image,
             const ImageMetadata& metadata) const override {
    write_exr(path, image, ExrSampleType::kFloat, metadata);
  }
  std::string file_extension() const override { return ".exr"; }
};

class PreviewSensor final : public Sensor {
 public:
  PreviewSensor(const Sensor& sensor, int width, int height, uint32_t samples, bool has_box_filter)
      : sensor_(sensor),
        corner_(sensor.film().crop().x0, sensor.film().crop().y0),
        scale_(Vec2(sensor.film().crop().width(), sensor.film().crop().height()) /
               Vec2(width, height)) {
    film_ = std::make_shared<PreviewFilm>(sensor.film(), width, height, has_box_filter);
    sampler_ = sensor.sampler().with_sample_count(samples);
  }

  Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const override {
    return sensor_.sample_ray(corner_ + scale_ * film_position, aperture);
  }
  void sample_ray_block(const Columns2& film_position, const Columns2& aperture, size_t count,
                        RayHit16* out) const override {
    constexpr size_t kChunkSize = 1024;
    alignas(kColumnAlignment) std::array<float, kChunkSize> x, y;
    for (size_t first = 0; first < count; first += kChunkSize) {
      const size_t chunk = std::min(kChunkSize, count - first);
      // The elements after the values can be arbitrary, but must be initialised.
      x.fill(0), y.fill(0);
      for (size_t i = 0; i < chunk; ++i) {
        x[i] = corner_.x + scale_.x * film_position.x[first + i];
        y[i] = corner_.y + scale_.y * film_position.y[first + i];
      }
      const Columns2 lens = aperture.x ? aperture.from(first) : aperture;
      sensor_.sample_ray_block({x.data(), y.data()}, lens, chunk, out + first / kBlockLanes);
    }
  }
  bool needs_aperture_sample() const override { return sensor_.needs_aperture_sample(); }
  std::optional<SensorConnection> connect(const Vec3& p, const Vec2& aperture) const override {
    auto seen = sensor_.connect(p, aperture);
    if (!seen) return std::nullopt;
    seen->film_position = (seen->film_position - corner_) / scale_;
    // The weight is inversely proportional to the solid angle of a pixel.
    seen->weight /= scale_.x * scale_.y;
    return seen;
  }

 private:
  const Sensor& sensor_;
  Vec2 corner_, scale_;
};

}  // namespace

std::unique_ptr<Sensor> with_own_film(const Sensor& sensor, int width, int height, uint32_t samples,
                                      bool has_box_filter) {
  return std::make_unique<PreviewSensor>(sensor, width, height, samples, has_box_filter);
}

}  // namespace kinome::viewer
