#include "clustered/media/sources/sun_points.h"

#include <algorithm>
#include <cmath>

#include "clustered/media/segment_distances.h"
#include "kinome/block_points.h"
#include "kinome/sampler.h"
#include "kinome/shape.h"
#include "kinome/wide/owen.h"

namespace kinome {
namespace {

using transport::MediaTable;
using transport::MediumLeg;

/// Use of random numbers (RandomSeeds).
constexpr uint32_t kPointUse = 0x73756e70;

/// Returns a uniform integer in [0, end).
uint32_t random_below(uint32_t end, uint64_t bits) {
  return static_cast<uint32_t>(to_unit_float(static_cast<uint32_t>(bits)) *
                               static_cast<float>(end));
}

}  // namespace

SunPoints::SunPoints(const transport::SceneTable& scene, const MediaTable& media,
                     const SunBeams& beams, size_t max_rays)
    : media_(media),
      beams_(beams),
      arena_((max_rays + kRaysPerSet - 1) / kRaysPerSet * kPointsPerSet),
      per_ray_(max_rays),
      segments_(scene, media, false, max_rays),
      met_(scene, max_rays),
      rays_(per_ray_.ray_hits()),
      ray_medium_(per_ray_.indices()),
      owner_(per_ray_.indices()),
      throughput_(per_ray_.three()),
      scatterings_(per_ray_.floats()),
      per_pdf_(per_ray_.floats()),
      cell_(per_ray_.indices()),
      p_(arena_.three()),
      axis_(arena_.three()),
      flux_(arena_.floats()),
      g_(arena_.floats()),
      points_(arena_.capacity()) {}

void SunPoints::draw(size_t rays, uint64_t seed, RenderCounters& counters) {
  sets_.assign(rays / kRaysPerSet, {});
  trace(rays, seed, counters);
  add_surfaces();
  add_media(seed);
  pad();
}

/// Traces rays of light to the first surface.
void SunPoints::trace(size_t rays, uint64_t seed, RenderCounters& counters) {
  const uint64_t key_x = hash_words(seed, kPointUse), key_y = hash_words(seed, kPointUse, 1);
  for (uint32_t i = 0; i < rays; ++i) {
    float pdf = 0;
    const Vec3 o = beams_.sample(owen_sobol_point(i, key_x, key_y), pdf, cell_[i]);
    per_pdf_[i] = 1 / (pdf * static_cast<float>(kRaysPerSet));
    set_ray(rays_[i / kBlockLanes].ray, i % kBlockLanes, Ray(o, -beams_.toward_light()));
    ray_medium_[i] = MediaTable::kVacuum;
    throughput_.set(i, Rgb(1.f));
    owner_[i] = 0, scatterings_[i] = 0;
  }
  legs_.clear();
  const uint32_t pixel = 0;
  const PixelSamples sample{&pixel, &pixel, 1, 0, 1, seed};
  const transport::PathState state{owner_,  ray_medium_,  throughput_, nullptr,
                                   nullptr, scatterings_, &legs_};
  segments_.trace(rays_, rays, state, transport::RandomSeeds(sample, kPointUse), RayKind::kBsdf,
                  counters);
  met_.find(rays_, rays, transport::Surfaces::Which::kAll);
}

void SunPoints::add_surfaces() {
  const SurfaceBlock& points = met_.points();
  for (size_t i = 0; i < met_.scattering(); ++i) {
    if (!(met_.live()[i] > 0)) continue;
    const Rgb flux = per_pdf_[points.ray[i]] * throughput_.at(points.ray[i]);
    if (!is_black(flux)) add_surface(i, flux);
  }
}

/// Adds point i of met_.
void SunPoints::add_surface(size_t i, const Rgb& flux) {
  const SurfaceInteraction si = interaction_of(met_.points(), i);
  const auto sample = beams_.emitter().sample_direct(si.p, Vec2(0.5f));
  if (!sample || !(sample->pdf > 0)) return;
  const Rgb irradiance = sample->radiance / sample->pdf;
  const LobeReflectance reflectance = si.shape->bsdf().reflectance(si);
  const uint32_t ray = met_.points().ray[i];
  const size_t set = ray / kRaysPerSet, k = set * kPointsPerSet + sets_[set].on_surfaces++;
  p_.set(k, si.p);
  axis_.set(k, glm::dot(si.n, beams_.toward_light()) < 0 ? -si.n : si.n);
  flux_[k] = mean_of(flux * irradiance * (reflectance.diffuse + reflectance.glossy)) / kPi;
  points_[k] = {si.p, cell_[ray], ray_medium_[ray], static_cast<uint32_t>(i), flux, irradiance};
}

/// Adds a point in each part of a ray in a medium, at most kMaxInMedia in each set.
void SunPoints::add_media(uint64_t seed) {
  first_leg_.assign(sets_.size() + 1, 0);
  for (const MediumLeg& leg : legs_) ++first_leg_[leg.path / kRaysPerSet + 1];
  for (size_t s = 0; s < sets_.size(); ++s) first_leg_[s + 1] += first_leg_[s];
  legs_of_set_.resize(legs_.size());
  std::vector<uint32_t> next(first_leg_.begin(), first_leg_.end() - 1);
  for (uint32_t l = 0; l < legs_.size(); ++l) {
    legs_of_set_[next[legs_[l].path / kRaysPerSet]++] = l;
  }
  const uint64_t key = hash_words(seed, kPointUse, 2), index_key = hash_words(seed, kPointUse, 3);
  for (size_t s = 0; s < sets_.size(); ++s) {
    const uint32_t count = first_leg_[s + 1] - first_leg_[s];
    const uint32_t step = std::max<uint32_t>(1, (count + kMaxInMedia - 1) / kMaxInMedia);
    for (uint32_t k = random_below(step, hash_words(seed, kPointUse + s, 4)); k < count;
         k += step) {
      const MediumLeg& leg = legs_[legs_of_set_[first_leg_[s] + k]];
      // The index is scrambled, because the numbers of the ray would be used again otherwise.
      const uint32_t index = owen_scramble(first_leg_[s] + k, index_key);
      add_in_medium(leg, owen_sobol_first(index, key), static_cast<float>(step));
    }
  }
}

/// Adds a point in a part of a ray. `u`: uniform; `factor`: reciprocal probability.
void SunPoints::add_in_medium(const MediumLeg& leg, float u, float factor) {
  const Rgb extinction = media_.extinction().at(leg.medium);
  const Rgb scattering = extinction * media_.albedo().at(leg.medium);
  if (is_black(scattering * leg.throughput) || !(leg.length > 0)) return;
  const AttenuatedDistances distances(min_extinction(extinction), leg.length);
  const float t = distances.at(u);
  const Rgb transmittance = glm::exp(-extinction * t);
  const Rgb flux = leg.throughput * transmittance * scattering *
                   (per_pdf_[leg.path] * factor / distances.density(t));
  const Vec3 p = leg.o + t * leg.d;
  const auto sample = beams_.emitter().sample_direct(p, Vec2(0.5f));
  if (!sample || !(sample->pdf > 0)) return;
  const Rgb irradiance = sample->radiance / sample->pdf;
  const size_t set = leg.path / kRaysPerSet;
  const size_t k = set * kPointsPerSet + kRaysPerSet + sets_[set].in_media++;
  p_.set(k, p);
  axis_.set(k, leg.d);
  flux_[k] = mean_of(flux * irradiance) / (4 * kPi);
  g_[k] = 0;
  for (const HgLobe& lobe : media_.medium(leg.medium)->phase().lobes()) {
    g_[k] += lobe.weight * lobe.g;
  }
  points_[k] = {p, cell_[leg.path], leg.medium, kInMedium, flux, irradiance};
}

/// Lists the points, and sets the flux of the padding to 0.
void SunPoints::pad() {
  indices_.clear();
  for (size_t s = 0; s < sets_.size(); ++s) {
    const auto list = [&](size_t first, size_t count) {
      for (size_t k = first; k < first + count; ++k) indices_.push_back(static_cast<uint32_t>(k));
      for (size_t k = first + count; k < first + padded(count); ++k) {
        p_.set(k, Vec3(0.f)), axis_.set(k, Vec3(0, 0, 1));
        flux_[k] = g_[k] = 0;
      }
    };
    list(s * kPointsPerSet, sets_[s].on_surfaces);
    list(s * kPointsPerSet + kRaysPerSet, sets_[s].in_media);
  }
}

FogSources::Light SunPoints::light(size_t index, const Vec3& p) const {
  const Point& from = point(index);
  const Vec3 to = from.p - p;
  const float r2 = glm::dot(to, to);
  if (!(r2 > 0)) return {};
  const float distance = std::sqrt(r2);
  const Vec3 d = to / distance, sun = beams_.toward_light();
  Rgb scattered(0.f);
  if (from.index != kInMedium) {
    SurfaceInteraction si = interaction_of(met_.points(), from.index);
    si.wi = si.frame.to_local(-d);
    const Rgb f = si.shape->bsdf().eval_pdf(si, Lobe::kAll, si.frame.to_local(sun)).f;
    // The points' density on the surface is proportional to the cosine of the light.
    const float cosine = std::abs(glm::dot(si.n, sun));
    if (cosine > 0) scattered = f * (std::abs(glm::dot(si.n, d)) / cosine);
  } else {
    const MediumPoint seen{from.p, Frame::from_normal(-d)};
    const Phase& phase = media_.medium(from.medium)->phase();
    scattered = Rgb(phase.eval(seen, seen.frame.to_local(sun)));
  }
  return {d, distance, scattered * from.flux * from.irradiance / r2, pdf(r2)};
}

}  // namespace kinome
