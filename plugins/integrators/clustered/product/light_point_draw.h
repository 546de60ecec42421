#pragma once

#include <optional>
#include <vector>

#include "clustered/product/local_light.h"
#include "kinome/emitter.h"
#include "kinome/owen.h"
#include "kinome/render_context.h"
#include "kinome/shape.h"
#include "kinome/warp.h"

namespace kinome {

/// What a draw was made of.
struct LightOrigin {
  uint32_t source = 0;
  LightGuide::Numbers numbers{};  ///< that the source is given
  float guided = 1;               ///< density by the guide over that without
  /// Density with aims over that without, times the share of the source's flux that is emitted
  /// toward them: about 1 for light that is aimed, small for other light.
  float aimed = 1;
  Vec2 position() const { return {numbers[0], numbers[1]}; }
  Vec2 direction() const { return {numbers[2], numbers[3]}; }
};

/// Numbers of the light points of one source: Owen-scrambled Sobol points.
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
    // Without an order of its own, each purpose would draw the same point of the sequence.
    return owen_sobol_point(owen_scramble(i, hash_words(key, 2)), key, hash_words(key, 1));
  }
  uint64_t seed_;
};

/// Whose turn it is: sources in proportion to their shares, as evenly as whole numbers allow, each
/// with an expectation of share x count.
class Turns {
 public:
  struct Turn {
    uint32_t source;
    uint32_t number;  ///< among the points of the source
  };
  /// `ends`: running sums of the shares.
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

/// A ray of a source's light.
struct LeavingLight {
  EmissionSample sample;
  std::optional<SurfaceInteraction> x;  ///< where it starts, if on a surface
};

/// Density of the directions that leave_light draws at a point of an emitting surface, per solid
/// angle: by the cosine with the shading normal, where that is the geometric one. Elsewhere flux
/// goes with one cosine and ends at the horizon of the other; a density by either would be nearly
/// zero where there is light.
inline bool has_bent_normal(const SurfaceInteraction& x) {
  return glm::dot(x.n, x.frame.n) < 1 - 1e-5f;
}
inline float surface_emission_pdf(const SurfaceInteraction& x, const Vec3& d) {
  const float cosine = glm::dot(x.frame.n, d);
  if (!(cosine > 0)) return 0;
  return has_bent_normal(x) ? kUniformHemispherePdf : cosine_hemisphere_pdf(cosine);
}

/// Samples light that leaves point x of an emitting surface, and sets x.wi. Returns nullopt if
/// there is none.
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

/// Light that leaves an emitter: nullopt where none does.
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

/// Density of d from y, toward light at x or, if that is nullptr, in the sky, the emitter being
/// given.
inline float arrival_density(const Emitter& emitter, const SurfaceInteraction* x,
                             const SurfaceInteraction& y, const Vec3& d) {
  return x ? x->shape->pdf_solid_angle(y.p, *x) : emitter.pdf_environment(d);
}

/// A path of light on its way to the next surface, where it leaves a light point.
struct LightWalk {
  LightOrigin origin;
  uint64_t seed = 0;                    ///< of what it does at surfaces
  uint32_t edges = 1;                   ///< with the one that it is on
  Vec3 d{0, 0, 1};                      ///< unit
  Rgb power{0.f};                       ///< EmissionSample::power, less what surfaces have taken
  /// True while no surface has turned the light. Surfaces that it has passed straight don't count
  /// (LocalLight::passing).
  bool is_direct = true;
  float before = 0;                     ///< distance along d to the last surface that was passed
  std::optional<SurfaceInteraction> x;  ///< where the path starts, if on a surface and direct
  /// By mirrors alone, from a source that no ray can find: neither can paths from the eye.
  bool is_hidden = false;
  bool is_shown = false;  ///< LightPoint::is_shown
};

/// What one thread draws.
struct LocalLight::Drawn {
  std::vector<LightPoint> points;
  std::vector<LightOrigin> origins;  ///< of the points
  std::vector<uint8_t> is_deep;      ///< of the points: their light has come by more than an edge
  std::vector<Reflection> reflections;
  std::vector<uint64_t> walk_of;     ///< of the points: seeds of their walks; 0 on emitters
  std::vector<LightWalk> walks;      ///< whose next edge isn't traced yet
  /// Parts of split walks that don't fit among the walks yet, and their rays.
  std::vector<std::pair<LightWalk, Ray>> parts;
  /// A kMirroring lobe was met by light of a source that has an extent, or of a lamp.
  bool meets_mirroring = false, lamp_meets_mirroring = false;
  RenderCounters counters;
};

}  // namespace kinome
