#include "transport/media/bodies/media_table.h"

#include <algorithm>

#include "transport/media/bodies/enclosed_media.h"

namespace kinome::transport {

namespace {

/// Radius of media that don't end: far beyond all collisions, but its square is finite.
constexpr float kUnboundedRadius = 1e15f;

}  // namespace

bool has_light_from_infinity(const Scene& scene) {
  return std::any_of(scene.emitters().begin(), scene.emitters().end(), [](const auto& emitter) {
    if (emitter->is_environment()) return true;
    if (!emitter->is_delta()) return false;
    const auto sample = emitter->sample_direct(Vec3(0.f), Vec2(0.5f));
    return sample && sample->distance == kInfinity;
  });
}

MediaTable::MediaTable(const Scene& scene, const Sensor& sensor) {
  const size_t count = scene.media().size() + 1;
  grids_.resize(count);
  coefficients_.resize(6 * count);
  float* const first = coefficients_.data();
  extinction_ = {first, first + count, first + 2 * count};
  albedo_ = extinction_.from(3 * count);
  for (const Medium* medium : scene.media()) add(*medium);
  for (const auto& shape : scene.shapes()) {
    const bool separates = shape->separates_media();
    // Rays hit curves only from outside, so that they couldn't leave the interior.
    const Medium* const inside = shape->curves() ? shape->exterior() : shape->interior();
    interior_.push_back(separates ? number_of(inside) : kUnchanged);
    exterior_.push_back(separates ? number_of(shape->exterior()) : kUnchanged);
  }
  start_ = number_of(sensor.medium());
  find_sphere(scene, sensor);
  find_enclosed(scene, sensor);
}

void MediaTable::add(const Medium& medium) {
  media_.push_back(&medium);
  owned_phases_.push_back(std::make_unique<PhaseBsdf>(medium.phase()));
  phases_.push_back(owned_phases_.back().get());
  is_coloured_ = is_coloured_ || medium.is_coloured();
  has_grids_ = has_grids_ || !medium.is_uniform();
  if (!medium.is_uniform()) {
    grids_[media_.size() - 1] = std::make_unique<MajorantGrid>(medium);
    return;
  }
  const MediumCoefficients at = medium.coefficients(Vec3(0.f), Vec3(0, 0, 1));
  extinction_.set(media_.size() - 1, at.extinction);
  Rgb albedo(0.f);
  for (int c = 0; c < 3; ++c) {
    if (at.extinction[c] > 0) albedo[c] = at.scattering[c] / at.extinction[c];
  }
  albedo_.set(media_.size() - 1, albedo);
}

void MediaTable::find_enclosed(const Scene& scene, const Sensor& sensor) {
  has_deltas_ = std::any_of(
      scene.emitters().begin(), scene.emitters().end(),
      [](const auto& emitter) { return !emitter->is_environment() && !emitter->is_surface(); });
  is_enclosed_.assign(media_.size(), false);
  ends_.assign(media_.size(), radius_ < kUnboundedRadius);
  for (uint32_t number = 1; number < media_.size(); ++number) {
    if (!is_unbounded(*media_[number], scene)) ends_[number] = true;
    is_enclosed_[number] = is_enclosed(*media_[number], scene, sensor);
    has_walks_ = has_walks_ || is_walked(number);
  }
}

uint32_t MediaTable::number_of(const Medium* medium) const {
  const auto found = std::find(media_.begin(), media_.end(), medium);
  return static_cast<uint32_t>(found - media_.begin());
}

void MediaTable::find_sphere(const Scene& scene, const Sensor& sensor) {
  if (!has_light_from_infinity(scene)) {
    radius_ = kUnboundedRadius;
    return;
  }
  const Aabb& shapes = scene.bounds();
  if (!shapes.empty()) {
    centre_ = shapes.centre();
    radius_ = 0.5f * glm::length(shapes.extent());
  }
  const Vec2 size(sensor.film().width(), sensor.film().height());
  for (const Vec2 at : {Vec2(0.5f), Vec2(0.f), Vec2(1.f), Vec2(0, 1), Vec2(1, 0)}) {
    const Vec3 from = sensor.sample_ray(at * size, Vec2(0.5f)).o;
    if (shapes.empty() && radius_ == 0) centre_ = from;
    radius_ = std::max(radius_, glm::length(from - centre_));
  }
}

}  // namespace kinome::transport
