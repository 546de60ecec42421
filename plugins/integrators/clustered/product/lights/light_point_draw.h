#pragma once

#include <optional>
#include <vector>

#include "clustered/product/lights/local_light.h"
#include "kinome/emitter.h"
#include "kinome/wide/owen.h"
#include "kinome/render_context.h"
#include "kinome/shape.h"
#include "kinome/warp.h"

namespace kinome {

/// Source and random numbers of a light point or light path.
struct LightOrigin {
  uint32_t source = 0;
  LightGuide::Numbers numbers{};  ///< random numbers for the source
  float guided = 1;               ///< density with the guide / density without
  /// Density with aim / density without, times the fraction of the source's flux that is emitted
  /// toward the spheres: about 1 for light that is aimed, small for other light.
  float aimed = 1;
  Vec2 position() const { return {numbers[0], numbers[1]}; }
  Vec2 direction() const { return {numbers[2], numbers[3]}; }
};

/// Random numbers for the light points of one source: Owen-scrambled Sobol points.
class LightNumbers {
 public:
  explicit LightNumbers(uint64_t seed) : seed_(seed) {}
  Vec2 position(uint32_t i) const { return number(1, i); }
  Vec2 direction(uint32_t i) const { return number(2, i); }
  LightOrigin origin(uint32_t source, uint32_t i) const {
    const Vec2 place = position(i), to = direction(i);
    return {source, {place.x, place.y, to.x, to.y}, 1};
  }

 private:
  Vec2 number(uint64_t purpose, uint32_t i) const {
    const uint64_t key = hash_words(seed_, purpose);
    // The index is scrambled, because both purposes would use the same Sobol point otherwise.
    return owen_sobol_point(owen_scramble(i, hash_words(key, 2)), key, hash_words(key, 1));
  }
  uint64_t seed_;
};

/// Divides `count` draws among sources in proportion to their shares, by systematic sampling. The
/// expected number of draws of a source is share x count.
class Turns {
 public:
  struct Turn {
    uint32_t source;
    uint32_t number;  ///< index among the draws of the source
  };
  /// `ends`: running sums of the shares. Must outlive this object.
  Turns(const std::vector<double>& ends, uint32_t count, uint64_t seed)
      : ends_(ends),
        scale_(ends.empty() ? 0 : ends.back() / count),
        offset_(to_unit_float(static_cast<uint32_t>(hash_words(seed, 0x7475726e) >> 32))) {}
  Turn operator[](uint32_t i) const {
    const auto after = std::upper_bound(ends_.begin(), ends_.end(), (i + offset_) * scale_);
    const size_t s = std::min<size_t>(after - ends_.begin(), ends_.size() - 1);
    const double begin = s > 0 ? ends_[s - 1] : 0.;
    const double first = std::max(0., std::ceil(begin / scale_ - offset_));
    return {static_cast<uint32_t>(s), i - std::min(i, static_cast<uint32_t>(first))};
  }

 private:
  const std::vector<double>& ends_;
  double scale_, offset_;
};

/// A light ray from a source.
struct LeavingLight {
  EmissionSample sample;
  std::optional<SurfaceInteraction> x;  ///< origin, if on a surface
};

/// True if the shading normal differs from the geometric normal.
inline bool has_bent_normal(const SurfaceInteraction& x) {
  return glm::dot(x.n, x.frame.n) < 1 - 1e-5f;
}
/// Returns the density, per solid angle, of the directions that leave_light samples at a point of
/// an emitting surface. It is proportional to the cosine if the normals are equal, else uniform.
/// With a bent normal, flux is proportional to one cosine, but ends at the horizon of the other. A
/// density proportional to either would be nearly 0 in some directions with light.
inline float surface_emission_pdf(const SurfaceInteraction& x, const Vec3& d) {
  const float cosine = glm::dot(x.frame.n, d);
  if (!(cosine > 0)) return 0;
  return has_bent_normal(x) ? kUniformHemispherePdf : cosine_hemisphere_pdf(cosine);
}

/// Samples light that leaves point x of an emitting surface, and sets x.wi. Returns nullopt if
/// sampling fails.
inline std::optional<EmissionSample> leave_surface(const Emitter& emitter, SurfaceInteraction& x,
                                                   Vec2 direction, const AimCones& cones = {}) {
  const int aimed = pick_aim(cones.count(), direction.x);
  if (aimed >= 0) {
    x.wi = x.frame.to_local(cones.sample(aimed, direction));
  } else {
    x.wi = has_bent_normal(x) ? square_to_uniform_hemisphere(direction)
                              : square_to_cosine_hemisphere(direction);
  }
  if (!(x.wi.z > 0)) return std::nullopt;
  EmissionSample sample;
  sample.o = x.p;
  sample.o_error = x.p_error;
  sample.n = x.n;
  sample.d = x.frame.to_world(x.wi);
  sample.pdf_direction = cones.pdf(sample.d, surface_emission_pdf(x, sample.d), aimed);
  if (!(sample.pdf_direction > 0)) return std::nullopt;
  const float area = emitter.shape()->area();
  sample.power =
      emitter.eval_surface(x) * (std::abs(glm::dot(x.n, sample.d)) * area / sample.pdf_direction);
  return sample;
}

/// Samples light that leaves an emitter. Returns nullopt if sampling fails.
inline std::optional<LeavingLight> leave_light(const Emitter& emitter, const Vec2& position,
                                               const Vec2& direction) {
  LeavingLight leaving;
  if (!emitter.is_surface()) {
    const auto sample = emitter.sample_emission(position, direction);
    if (!sample) return std::nullopt;
    leaving.sample = *sample;
    return leaving;
  }
  if (!(emitter.shape()->area() > 0)) return std::nullopt;
  leaving.x = emitter.shape()->sample_surface(position);
  leaving.x->shape = emitter.shape();
  const auto sample = leave_surface(emitter, *leaving.x, direction);
  if (!sample) return std::nullopt;
  leaving.sample = *sample;
  return leaving;
}

/// Density of direction d from y for light sampling, given the emitter. The light is at x; nullptr
/// for the sky.
inline float arrival_density(const Emitter& emitter, const SurfaceInteraction* x,
                             const SurfaceInteraction& y, const Vec3& d) {
  return x ? x->shape->pdf_solid_angle(y.p, *x) : emitter.pdf_environment(d);
}

/// A light path on its way to the next surface, where it leaves a light point.
struct LightWalk {
  LightOrigin origin;
  uint64_t seed = 0;                    ///< for its random numbers at surfaces
  uint32_t edges = 1;                   ///< including the current one
  Vec3 d{0, 0, 1};                      ///< unit
  Rgb power{0.f};                       ///< EmissionSample::power x the weights at all surfaces
  /// True while no surface has turned the light. Surfaces that it has passed straight don't count
  /// (LocalLight::passing).
  bool is_direct = true;
  float before = 0;                     ///< distance along d to the last surface that was passed
  std::optional<SurfaceInteraction> x;  ///< origin of the path, if on a surface and direct
  /// True if the light has come from a lamp by delta lobes alone. Paths from the eye can't find it.
  bool is_hidden = false;
  bool is_shown = false;  ///< LightPoint::is_shown
};

/// Light points drawn by one thread.
struct LocalLight::Drawn {
  std::vector<LightPoint> points;
  std::vector<LightOrigin> origins;  ///< of each point
  std::vector<uint8_t> is_deep;      ///< for each point, 1 if its light has come by several edges
  std::vector<Reflection> reflections;
  std::vector<uint64_t> walk_of;  ///< for each point, seed of its walk; 0 on emitters
  std::vector<LightWalk> walks;   ///< walks whose next edge isn't traced yet
  /// Parts of split walks that don't fit into `walks` yet, with their rays.
  std::vector<std::pair<LightWalk, Ray>> parts;
  /// lamp_meets_mirroring: direct light of a lamp has hit a kMirroring lobe. meets_mirroring: other
  /// light has.
  bool meets_mirroring = false, lamp_meets_mirroring = false;
  RenderCounters counters;
};

}  // namespace kinome
