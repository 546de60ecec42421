#include "check/emitter_scene.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "check/rays.h"
#include "check/surroundings.h"
#include "kinome/warp.h"

namespace kinome::check {

EmitterScene::EmitterScene(const Subject& subject)
    : scene_(subject.scene(surroundings(subject, subject.xml()))) {
  for (const Emitter* emitter : scene_->emitters()) {
    if (!emitter_ && emitter->plugin() == subject.title()) emitter_ = emitter;
  }
  if (!emitter_) throw Error("the scene that it is put in doesn't list it among its emitters");
  is_surface_ = emitter_->shape() != nullptr;
}

Vec3 EmitterScene::place(Random& random) const {
  const float x = random.between(-1, 1), y = random.between(-1, 1);
  return {x, y, random.between(0, 0.4f)};
}

double EmitterScene::pdf_along(const Vec3& p, const Vec3& d) const {
  if (!is_surface_) return double{emitter_->pdf_environment(d)};
  return double{density_along(*scene_, p, d, [&](const SurfaceInteraction& si) {
    return si.shape == emitter_->shape() ? emitter_->pdf_surface(p, si) : 0.f;
  })};
}

std::optional<float> EmitterScene::pdf_of(const Vec3& p, const DirectSample& sample) const {
  if (!is_surface_) return emitter_->pdf_environment(sample.d);
  RayHit ray = ray_hit(p, sample.d);
  ray.ray.tmin = sample.distance * 0.999f;
  RenderCounters counters;
  scene_->intersect({&ray, 1}, Coherence::kIncoherent, counters);
  if (!ray.hit.valid()) return std::nullopt;
  const SurfaceInteraction si = scene_->interaction(ray);
  if (si.shape != emitter_->shape()) return std::nullopt;
  return emitter_->pdf_surface(p, si);
}

const char* EmitterScene::value_name() const {
  if (is_surface_) return "eval_surface()";
  return emitter_->is_environment() ? "eval_environment()" : "sample_direct()";
}

std::pair<Vec3, Rgb> EmitterScene::reference_emission(Random& random, const Vec3& o) const {
  if (is_surface_) {
    const Shape& shape = *emitter_->shape();
    SurfaceInteraction si = shape.sample_surface(random.unit2());
    si.shape = &shape;
    const Vec3 d = random.direction();
    si.wi = si.frame.to_local(d);
    const float weight = std::abs(glm::dot(si.n, d)) * 4 * kPi * shape.area();
    return {d, emitter_->eval_surface(si) * weight};
  }
  if (emitter_->is_environment()) {
    const auto sample = emitter_->sample_direct(Vec3(0.f), random.unit2());
    if (!sample || !(sample->pdf > 0)) return {Vec3(0, 0, 1), Rgb(0.f)};
    return {-sample->d, sample->radiance / sample->pdf};
  }
  // Light from a place: its intensity by what arrives around it; parallel light is the same
  // everywhere.
  const Vec3 d = random.direction();
  const auto sample = emitter_->sample_direct(o + d, Vec2(0.5f));
  if (!sample) return {d, Rgb(0.f)};
  if (!(sample->distance < kInfinity)) return {-sample->d, sample->radiance};
  return {d, sample->radiance * sqr(sample->distance) * (4 * kPi)};
}

float ratio_of(float a, float b) {
  const float ratio = a / b;
  return std::isnan(ratio) ? kInfinity : ratio;
}

float middle_of(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string cause_of(const DensityVerdict& verdict, const std::string& pdf_name) {
  const double ratio = verdict.mass / verdict.accepted;
  if (!(verdict.accepted > 0)) return "no sample is had, where " + pdf_name + " says there are";
  if (!(std::abs(ratio - 1) < 0.02)) {
    return fmt::format("{} integrates to {:.3f}, and {:.3f} of the tries give a sample: it is "
                       "{:.3g} times what it must be",
                       pdf_name, verdict.mass, verdict.accepted, ratio);
  }
  return fmt::format("samples don't follow {}: around ({:.3f}, {:.3f}, {:.3f}) there are {:.2g} of "
                     "them, and it says {:.2g}",
                     pdf_name, verdict.worst.x, verdict.worst.y, verdict.worst.z,
                     verdict.worst_sampled, verdict.worst_told);
}

}  // namespace kinome::check
