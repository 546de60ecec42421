#include "luck.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <random>
#include <vector>

#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/film.h"
#include "kinome/render_context.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/warp.h"

namespace kinome::test {
namespace {

/// Returns true if a value that the text gives to a parameter of these names satisfies the
/// predicate.
template <class Predicate>
bool any_value(const std::string& text, std::initializer_list<const char*> names,
               const Predicate& predicate) {
  for (const char* name : names) {
    const std::string key = std::string("\"") + name + "\"";
    for (size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
      const size_t value = text.find("value=\"", at);
      if (value == std::string::npos) break;
      // Only the first channel of a colour is tested.
      if (predicate(std::strtod(text.c_str() + value + 7, nullptr))) return true;
    }
  }
  return false;
}

/// Returns a ray of the sensor for a film position in the unit square and a lens position.
Ray ray_of(const Scene& scene, const Vec2& place, const Vec2& lens = Vec2(0.5f)) {
  const Sensor& sensor = *scene.sensors().at(0);
  const Rect& crop = sensor.film().crop();
  const Vec2 first(static_cast<float>(crop.x0), static_cast<float>(crop.y0));
  const Vec2 size(static_cast<float>(crop.x1 - crop.x0), static_cast<float>(crop.y1 - crop.y0));
  return sensor.sample_ray(first + place * size, lens);
}

/// Returns a random point of the unit square.
Vec2 square_of(std::mt19937& random) {
  std::uniform_real_distribution<float> number(0, 0x1.fffffep-1f);
  const float x = number(random);
  return Vec2(x, number(random));
}

/// Calls use(hit) for the hits of `side`^2 camera rays.
template <class Use>
void for_all_seen(const Scene& scene, int side, const Use& use) {
  RenderCounters counters;
  std::mt19937 random(1);
  for (int i = 0; i < side * side; ++i) {
    const Vec2 cell(static_cast<float>(i % side), static_cast<float>(i / side));
    RayHit hit;
    hit.ray = ray_of(scene, (cell + 0.5f) / static_cast<float>(side), square_of(random));
    scene.intersect({&hit, 1}, Coherence::kIncoherent, counters);
    if (hit.hit.valid()) use(hit);
  }
}

/// Returns the distances to the hits of `side`^2 camera rays.
std::vector<float> seen_distances(const Scene& scene, int side) {
  std::vector<float> distances;
  for_all_seen(scene, side, [&](const RayHit& hit) { distances.push_back(hit.ray.tmax); });
  return distances;
}

/// Returns the reflected radiance of one emitter sample.
double reflection_of(const SurfaceInteraction& si, const DirectSample& light) {
  const BsdfValue value = si.shape->bsdf().eval_pdf(si, Lobe::kAll, si.frame.to_local(light.d));
  // Large lamps are also found by BSDF sampling (MIS), points never are.
  const double pdf = double{light.pdf} + (light.is_delta ? 0 : value.pdf);
  const double radiance = double{max_component(value.f * light.radiance)} / pdf;
  return std::isfinite(radiance) ? radiance : 0;
}

}  // namespace

bool has_sharp_lobes(const std::string& text, double min_alpha) {
  constexpr double kMaxExponent = 1000;
  // The default alpha is 0.1, and the default exponent 30.
  const auto has = [&](const char* word) { return text.find(word) != std::string::npos; };
  const bool is_rough = has("\"rough") || has("\"ward\"") || has("\"phong\"");
  const bool is_silent = !has("\"alpha") && !has("\"exponent\"");
  if (is_rough && is_silent && min_alpha > 0.1) return true;
  const double largest = kMaxExponent * sqr(kMinAlpha / min_alpha);
  return any_value(text, {"alpha", "alpha_u", "alpha_v"},
                   [&](double alpha) { return alpha < min_alpha; }) ||
         any_value(text, {"exponent"}, [&](double exponent) { return exponent > largest; });
}

bool has_mirrors(const Scene& scene) {
  return std::any_of(scene.shapes().begin(), scene.shapes().end(),
                     [](const auto& shape) { return any(shape->bsdf().lobes() & Lobe::kDelta); });
}

bool has_faint_lobes(const std::string& text) {
  constexpr double kMinReflectance = 1e-4;
  return any_value(text, {"diffuse_reflectance", "specular_reflectance", "color0", "color1"},
                   [](double red) { return red > 0 && red < kMinReflectance; });
}

bool has_needles(const std::string& text) {
  constexpr double kMinAngle = 0.1;  // degrees
  return any_value(text, {"cutoff_angle"}, [](double angle) { return angle < kMinAngle; });
}

bool has_specks(const Scene& scene) {
  constexpr float kMinFraction = 1e-5f;
  const float size = glm::length(scene.bounds().extent());
  return std::any_of(scene.shapes().begin(), scene.shapes().end(), [&](const auto& shape) {
    return shape->emitter() && shape->area() < kMinFraction * size * size;
  });
}

bool is_hardly_seen(const Scene& scene, double rays) {
  constexpr int kSide = 64;
  constexpr double kFew = 10;
  const double share = static_cast<double>(seen_distances(scene, kSide).size()) / sqr(kSide);
  return share * rays < kFew;
}

bool sees_few_photons(const Scene& scene, double photons, double few) {
  constexpr int kSide = 8;
  std::vector<float> distances = seen_distances(scene, kSide);
  if (distances.empty()) return true;
  std::sort(distances.begin(), distances.end());
  const float middle = distances[distances.size() / 2];
  const double seen =
      glm::distance(ray_of(scene, Vec2(0)).at(middle), ray_of(scene, Vec2(1)).at(middle));
  const double share = seen / glm::length(scene.bounds().extent());
  return !(photons * share * share > few);
}

bool has_vast_flux(const Scene& scene, bool of_sky) {
  constexpr int kDraws = 64;
  constexpr float kMaxPower = 1e30f;
  std::mt19937 random(1);
  for (const Emitter* emitter : scene.emitters()) {
    if (emitter->is_environment() && !of_sky) continue;
    for (int i = 0; i < kDraws; ++i) {
      const Vec2 position = square_of(random), direction = square_of(random);
      const auto emission = emitter->sample_emission(position, direction);
      if (emission && !(max_component(emission->power) < kMaxPower)) return true;
    }
  }
  return false;
}

double brightest_reflection(const Scene& scene) {
  constexpr int kPhotons = 4096, kDirections = 8;  // per emitter, and per hit
  RenderCounters counters;
  std::mt19937 random(1);
  double brightest = 0;
  for (const Emitter* emitter : scene.emitters()) {
    for (int i = 0; i < kPhotons; ++i) {
      const Vec2 position = square_of(random), direction = square_of(random);
      const auto emission = emitter->sample_emission(position, direction);
      if (!emission) continue;
      RayHit hit;
      hit.ray = emission->ray();
      scene.intersect({&hit, 1}, Coherence::kIncoherent, counters);
      if (!hit.hit.valid()) continue;
      SurfaceInteraction si = scene.interaction(hit);
      const auto light = emitter->sample_direct(si.p, square_of(random));
      if (!light || !(light->pdf > 0)) continue;
      for (int k = 0; k < kDirections; ++k) {
        si.wi = square_to_uniform_sphere(square_of(random));
        brightest = std::max(brightest, reflection_of(si, *light));
      }
    }
  }
  return brightest * static_cast<double>(scene.emitters().size());
}

double brightest_hidden(const Scene& scene) {
  constexpr int kSide = 32, kDraws = 4;
  RenderCounters counters;
  std::mt19937 random(1);
  double brightest = 0;
  for_all_seen(scene, kSide, [&](const RayHit& hit) {
    const SurfaceInteraction si = scene.interaction(hit);
    for (const Emitter* emitter : scene.emitters()) {
      for (int i = 0; i < kDraws; ++i) {
        const auto light = emitter->sample_direct(si.p, square_of(random));
        if (!light || !(light->pdf > 0)) continue;
        const double radiance = reflection_of(si, *light);
        if (!(radiance > brightest)) continue;
        Ray shadow = si.shadow_ray(light->d, light->distance);
        scene.occluded({&shadow, 1}, Coherence::kIncoherent, counters);
        if (shadow.is_occluded()) brightest = radiance;
      }
    }
  });
  return brightest;
}

}  // namespace kinome::test
