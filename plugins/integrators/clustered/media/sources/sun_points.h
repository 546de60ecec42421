#pragma once

#include <cstdint>
#include <vector>

#include "clustered/media/hg_terms.h"
#include "clustered/media/sources/fog_sources.h"
#include "clustered/media/sources/sun_beams.h"
#include "kinome/wide/vectors.h"
#include "transport/blocks/arena.h"
#include "transport/media/tracking/segments.h"
#include "transport/surfaces/surfaces.h"

namespace kinome {

/// Points where light of a distant emitter is scattered for the first time, on surfaces and in
/// media: light points whose light paths find by emitter samples. One per thread.
///
/// An emitter sample at a point x that chooses the light point y finds the same light as a path
/// from x that is scattered at y and takes an emitter sample there. The power heuristic for pdf()
/// and the density of the path's direction shares the light between both. So the 1/r² of the former
/// causes no infinite variance, and paths find the light of sharp reflections.
class SunPoints {
 public:
  /// Number of rays in each set of points. The rays of a set are well distributed, and so are those
  /// of all sets together. The light of each set has the same expectation: that of the sun.
  static constexpr size_t kRaysPerSet = 32;
  /// Maximum number of points of a set in media. If there are more parts of rays, random ones are
  /// left out.
  static constexpr size_t kMaxInMedia = 64;
  /// Number of columns of a set: points on surfaces, then points in media.
  static constexpr size_t kPointsPerSet = kRaysPerSet + kMaxInMedia;

  /// `max_rays`: maximum number of rays of light of draw().
  SunPoints(const transport::SceneTable& scene, const transport::MediaTable& media,
            const SunBeams& beams, size_t max_rays);

  /// Replaces all points. `rays`: a multiple of kRaysPerSet. The same seed gives the same points.
  void draw(size_t rays, uint64_t seed, RenderCounters& counters);
  size_t sets() const { return sets_.size(); }
  /// Numbers of points of a set on surfaces, and in media. The latter begin at kRaysPerSet.
  size_t on_surfaces(size_t set) const { return sets_[set].on_surfaces; }
  size_t in_media(size_t set) const { return sets_[set].in_media; }
  /// Indices of all points. Those of a set begin at set * kPointsPerSet.
  const std::vector<uint32_t>& indices() const { return indices_; }

  /// Irradiance that points on surfaces i ... cause without occlusion and attenuation on surfaces
  /// that face them, and unit directions toward them. Estimates, for importances; 0 for padding.
  KINOME_WIDE wide::Float irradiance_of_surfaces(size_t i, const wide::Vec3& p,
                                                 wide::Vec3& toward) const;
  /// The same for points in media.
  KINOME_WIDE wide::Float irradiance_of_media(size_t i, const wide::Vec3& p,
                                              wide::Vec3& toward) const;
  /// Density of light points in weights against samples of a BSDF or a phase function, per solid
  /// angle, at the squared distance r2.
  float pdf(float r2) const { return r2 / (4 * kPi * beams_.near2()); }
  /// Light at p of a point, as if its set were alone.
  FogSources::Light light(size_t index, const Vec3& p) const;

  struct Point {
    Vec3 p;
    uint32_t cell;    ///< of SunBeams
    uint32_t medium;  ///< before the point
    uint32_t index;   ///< on surfaces: of met_.points(); in media: kInMedium
    Rgb flux;         ///< [W], divided by `irradiance`
    Rgb irradiance;   ///< of a surface that faces the light
  };
  static constexpr uint32_t kInMedium = UINT32_MAX;
  const Point& point(size_t index) const { return points_[index]; }
  /// Returns the geometric normal of a point, 0 in media, and the error of its position.
  Vec3 normal(size_t index) const {
    const uint32_t i = points_[index].index;
    return i == kInMedium ? Vec3(0.f) : met_.points().n.at(i);
  }
  float error(size_t index) const {
    const uint32_t i = points_[index].index;
    return i == kInMedium ? 0.f : met_.points().p_error[i];
  }

 private:
  struct Set {
    size_t on_surfaces = 0, in_media = 0;
  };
  /// Minimum cosine and phase function, since both are approximations.
  static constexpr float kMinCosine = 0.02f, kMinPhase = 0.1f;

  void trace(size_t rays, uint64_t seed, RenderCounters& counters);
  void add_surfaces();
  void add_surface(size_t i, const Rgb& flux);
  void add_media(uint64_t seed);
  void add_in_medium(const transport::MediumLeg& leg, float u, float factor);
  void pad();
  /// Squared distances of p from points i ..., and unit directions toward them.
  KINOME_WIDE wide::Float distance2(size_t i, const wide::Vec3& p, wide::Vec3& toward) const;

  const transport::MediaTable& media_;
  const SunBeams& beams_;
  transport::Arena arena_, per_ray_;
  transport::Segments segments_;
  transport::Surfaces met_;
  RayHit16* rays_;
  uint32_t* ray_medium_;
  uint32_t* owner_;
  Columns3 throughput_;
  float* scatterings_;
  float* per_pdf_;  ///< area of each ray
  uint32_t* cell_;  ///< of each ray
  std::vector<transport::MediumLeg> legs_;
  std::vector<uint32_t> legs_of_set_, first_leg_;  ///< indices into legs_, set by set
  Columns3 p_;
  Columns3 axis_;  ///< normal on the side of the light, or direction in which the light travels
  float* flux_;    ///< mean of channels; times the albedo on surfaces
  float* g_;       ///< mean cosine of the phase function
  std::vector<Point> points_;
  std::vector<Set> sets_;
  std::vector<uint32_t> indices_;
};

KINOME_WIDE wide::Float SunPoints::distance2(size_t i, const wide::Vec3& p,
                                             wide::Vec3& toward) const {
  using namespace wide;
  const wide::Vec3 to = wide::Vec3::load(p_, i) - p;
  const Float r2 = dot(to, to);
  toward = to / sqrt(max(r2, Float(1e-30f)));
  return r2;
}

KINOME_WIDE wide::Float SunPoints::irradiance_of_surfaces(size_t i, const wide::Vec3& p,
                                                          wide::Vec3& toward) const {
  using namespace wide;
  const Float r2 = distance2(i, p, toward);
  const Float cosine = max(-dot(wide::Vec3::load(axis_, i), toward), Float(kMinCosine));
  return Float::load(flux_ + i) * cosine / (r2 + beams_.near2());
}

KINOME_WIDE wide::Float SunPoints::irradiance_of_media(size_t i, const wide::Vec3& p,
                                                       wide::Vec3& toward) const {
  using namespace wide;
  const Float r2 = distance2(i, p, toward);
  const Float cosine = -dot(wide::Vec3::load(axis_, i), toward);
  const auto terms = HgTerms<Float>::of(Float::load(g_ + i), 1.f);
  const Float phase = max(terms.at(cosine), Float(kMinPhase));
  return Float::load(flux_ + i) * phase / (r2 + beams_.near2());
}

}  // namespace kinome
