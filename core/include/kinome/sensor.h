#pragma once

#include <memory>

#include "kinome/film.h"
#include "kinome/object.h"
#include "kinome/ray.h"
#include "kinome/sampler.h"

namespace kinome {

/// A camera with its film and sampler.
class KINOME_EXPORT Sensor : public Object {
 public:
  /// Ray through the film position (pixels of the full film, (0,0) its upper left corner; need not
  /// lie inside). `aperture` in [0,1)² picks the point of the lens. d has unit length; tmin and
  /// tmax are the near and far clip distances along it.
  virtual Ray sample_ray(const Vec2& film_position, const Vec2& aperture) const = 0;
  /// True where `aperture` matters.
  virtual bool needs_aperture_sample() const { return false; }

  Film& film() const { return *film_; }
  const Sampler& sampler() const { return *sampler_; }

 protected:
  std::shared_ptr<Film> film_;
  std::shared_ptr<Sampler> sampler_;
};

}  // namespace kinome
