#pragma once

#include <memory>
#include <optional>

#include "kinome/blocks.h"
#include "kinome/film.h"
#include "kinome/object.h"
#include "kinome/ray.h"
#include "kinome/sampler.h"

namespace kinome {

/// How the camera sees a point: for light tracing.
struct SensorConnection {
  Vec2 film_position{0.f};
  Vec3 d{0, 0, 1};  ///< unit, from the point toward the lens
  /// From the point to where the near clip begins, world units: what lies beyond can't hide it.
  float distance = 0;
  /// What radiant intensity toward the lens [W/sr] counts as pixel radiance: 1 / (solid angle of a
  /// pixel there x distance² x density). The pixel's value is the sum over all light paths of
  /// intensity x weight / number of paths, spread by the film's filter.
  float weight = 0;
};

class Shape;

/// Times at which a sensor's shutter opens and closes; open <= close.
struct Shutter {
  float open = 0;
  float close = 0;

  Shutter() = default;
  Shutter(float open_time, float close_time) : open(open_time), close(close_time) {}
  bool operator==(const Shutter&) const = default;
};

/// A camera, or another measuring device, with its film and sampler.
class KINOME_EXPORT Sensor : public Object {
 public:
  /// Called once all shapes are known, before any ray is asked for. `bounds` of the whole scene;
  /// empty where there are no shapes.
  virtual void set_scene_bounds(const Aabb& /*bounds*/) {}
  /// Whether it measures at a shape, and must be part of one.
  virtual bool is_surface() const { return false; }
  /// The shape that it is part of, while that is made: nothing may be asked of it yet. Called where
  /// is_surface().
  virtual void attach(const Shape& /*shape*/) {}
  /// Ray through the film position (pixels of the full film, (0,0) its upper left corner; need not
  /// lie inside). `aperture` in [0,1)² picks the point of the lens. d has unit length; tmin and
  /// tmax are the near and far clip distances along it.
  virtual Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const = 0;
  /// sample_ray of each position: o, d, tmin and tmax of out[i / 16]. Default: one by one.
  virtual void sample_ray_block(const Columns2& film_position, const Columns2& aperture,
                                size_t count, RayHit16* out) const;
  /// True where `aperture` matters.
  virtual bool needs_aperture_sample() const { return false; }
  /// Where p is seen, through a sampled point of the lens; nullopt where it isn't (behind the
  /// camera, out of the clip range, outside Film::sampled()). Visibility is the caller's business.
  virtual std::optional<SensorConnection> connect(const Vec3& /*p*/,
                                                  const Vec2& /*aperture*/) const {
    return std::nullopt;
  }
  /// connect() of each p. Default: one by one.
  virtual void connect_block(const Columns3& p, const Columns2& aperture, size_t count,
                             const ConnectionBlock& out) const;

  /// This sensor with the same film, for another number of samples; must not outlive it.
  std::unique_ptr<Sensor> with_sample_count(uint32_t count) const;

  Film& film() const { return *film_; }
  const Sampler& sampler() const { return *sampler_; }
  const Shutter& shutter() const { return shutter_; }

 protected:
  std::shared_ptr<Film> film_;
  std::shared_ptr<Sampler> sampler_;
  Shutter shutter_;
};

}  // namespace kinome
