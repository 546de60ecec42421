#pragma once

#include <memory>
#include <optional>

#include "kinome/blocks.h"
#include "kinome/film.h"
#include "kinome/medium.h"
#include "kinome/object.h"
#include "kinome/ray.h"
#include "kinome/sampler.h"

namespace kinome {

/// Connection from a surface point to the sensor, for light tracing.
struct SensorConnection {
  Vec2 film_position{0.f};
  Vec3 d{0, 0, 1};  ///< unit direction from the point toward the lens
  /// Distance from the point to the near clip plane, world units. Objects beyond it don't occlude
  /// the point.
  float distance = 0;
  /// Factor from radiant intensity toward the lens [W/sr] to pixel radiance: 1 / (solid angle of
  /// the pixel there x distance² x density). The pixel's value is the sum over all light paths of
  /// intensity x weight / number of paths, spread by the film's filter.
  float weight = 0;
};

class Shape;

/// Opening and closing time of a sensor's shutter; open <= close.
struct Shutter {
  float open = 0;
  float close = 0;

  Shutter() = default;
  Shutter(float open_time, float close_time) : open(open_time), close(close_time) {}
  bool operator==(const Shutter&) const = default;
};

/// Camera or other measuring device, with its film and sampler.
class KINOME_EXPORT Sensor : public Object {
 public:
  /// Sets the bounds of the whole scene, which are empty without shapes. Called once all shapes are
  /// known, before rays are sampled.
  virtual void set_scene_bounds(const Aabb& /*bounds*/) {}
  /// True if the sensor measures at a shape; it must then be nested in one.
  virtual bool is_surface() const { return false; }
  /// Sets the shape that contains the sensor, if is_surface(). The shape is still under
  /// construction: only its address may be stored.
  virtual void attach(const Shape& /*shape*/) {}
  /// Samples a ray through a film position (pixels of the full film, origin at the upper left; may
  /// be outside). `aperture` in [0,1)² chooses the lens point. d is a unit vector; tmin and tmax
  /// are the near and far clip distances along it.
  virtual Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const = 0;
  /// Samples a ray for each position: sets o, d, tmin and tmax of lane i % 16 of out[i / 16].
  /// Default: calls sample_ray() one by one.
  virtual void sample_ray_block(const Columns2& film_position, const Columns2& aperture,
                                size_t count, RayHit16* out) const;
  /// True if sample_ray() and connect() depend on `aperture`.
  virtual bool needs_aperture_sample() const { return false; }
  /// Computes where p is seen through a sampled point of the lens. Returns nullopt if p is behind
  /// the camera, outside the clip range or outside Film::sampled(). The caller tests occlusion.
  virtual std::optional<SensorConnection> connect(const Vec3& /*p*/,
                                                  const Vec2& /*aperture*/) const {
    return std::nullopt;
  }
  /// Calls connect() for each p. Default: one by one.
  virtual void connect_block(const Columns3& p, const Columns2& aperture, size_t count,
                             const ConnectionBlock& out) const;

  /// Returns this sensor with the same film and another sample count. The copy must not outlive
  /// this sensor.
  std::unique_ptr<Sensor> with_sample_count(uint32_t count) const;

  Film& film() const { return *film_; }
  const Sampler& sampler() const { return *sampler_; }
  const Shutter& shutter() const { return shutter_; }
  /// Medium in which rays start; nullptr: none.
  const Medium* medium() const { return medium_.get(); }

 protected:
  std::shared_ptr<Film> film_;
  std::shared_ptr<Sampler> sampler_;
  std::shared_ptr<const Medium> medium_;
  Shutter shutter_;
};

}  // namespace kinome
