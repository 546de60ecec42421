#include "kit/scenes/emitter_scene.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/warp.h"
#include "kit/scenes/rays.h"
#include "kit/subject.h"

namespace kinome::check {

EmitterScene::EmitterScene(const Subject& subject, int index)
    : EmitterScene(subject, subject.xml(), index) {}

EmitterScene::EmitterScene(const Subject& subject, const std::string& xml, int index)
    : scene_(subject.scene(surroundings(subject, xml))) {
  const auto object = subject.load(xml);
  for (const Emitter* emitter : scene_->emitters()) {
    if (emitter->plugin() == object->plugin() && index-- == 0) emitter_ = emitter;
  }
  if (!emitter_) throw Error("Scene::emitters() of the test scene doesn't contain the emitter");
  is_surface_ = emitter_->shape() != nullptr;
}

int EmitterScene::count(const Subject& subject) {
  return subject.make<Emitter>()->is_surface() ? 2 : 1;
}

Vec3 EmitterScene::random_point(Random& random) const {
  const float x = random.between(-1, 1), y = random.between(-1, 1);
  const Vec3 anywhere(x, y, random.between(0, 0.4f));
  // Half of the points are on the emitter's rays, because others would miss a narrow beam.
  if (!emitter_->is_delta() || random.unit() < 0.5f) return anywhere;
  const auto ray = random_emission(*emitter_, random);
  if (!ray || ray->pdf_position > 0 || !is_finite(ray->o) || !is_finite(ray->d)) return anywhere;
  return ray->o + random.between(0.2f, 2) * ray->d;
}

double EmitterScene::pdf_along(const Vec3& p, const Vec3& d) const {
  if (!is_surface_) return double{emitter_->pdf_environment(d)};
  return double{density_along(*scene_, p, d, [&](const SurfaceInteraction& si) {
    return si.shape == emitter_->shape() ? emitter_->pdf_surface(p, si) : 0.f;
  })};
}

std::optional<float> EmitterScene::pdf_of(const Vec3& p, const DirectSample& sample) const {
  if (!is_surface_) return emitter_->pdf_environment(sample.d);
  const RayHit ray = trace(*scene_, p, sample.d, sample.distance * 0.999f);
  if (!ray.hit.valid()) return std::nullopt;
  const SurfaceInteraction si = scene_->interaction(ray);
  if (si.shape != emitter_->shape()) return std::nullopt;
  return emitter_->pdf_surface(p, si);
}

const char* EmitterScene::value_name() const {
  if (is_surface_) return "eval_surface()";
  return emitter_->is_environment() ? "eval_environment()" : "sample_direct()";
}

std::pair<Vec3, Rgb> EmitterScene::reference_emission(Random& random, const Vec3& o) {
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
  // For an emitter at a point, the reference is the light that arrives around it; parallel light is
  // the same everywhere. Half of the directions are in the beam, because others would miss a narrow
  // one.
  if (!cone_) cone_ = EmissionCone(*emitter_);
  const Vec3 d = random.unit() < 0.5f ? random.direction() : cone_->direction(random);
  const auto sample = emitter_->sample_direct(o + d, Vec2(0.5f));
  if (!sample) return {d, Rgb(0.f)};
  if (!(sample->distance < kInfinity)) return {-sample->d, sample->radiance};
  const float pdf = 0.5f * kUniformSpherePdf + 0.5f * cone_->pdf(d);
  return {d, sample->radiance * (sqr(sample->distance) / pdf)};
}

EmitterScene::EmissionCone::EmissionCone(const Emitter& emitter) {
  Random random(0);
  std::vector<Vec3> directions;
  Vec3 sum(0.f);
  for (int i = 0; i < 4000; ++i) {
    const auto ray = random_emission(emitter, random);
    if (!ray || !is_finite(ray->d)) continue;
    directions.push_back(ray->d);
    sum += ray->d;
  }
  if (!(glm::length(sum) > 0)) return;
  frame_ = Frame::from_normal(glm::normalize(sum));
  height_ = 0;
  for (const Vec3& d : directions) height_ = std::max(height_, height_of(d));
  height_ = std::clamp(1.5f * height_, 1e-8f, 2.f);
}

float EmitterScene::EmissionCone::height_of(const Vec3& d) const {
  const Vec3 local = frame_.to_local(d);
  const float sine2 = sqr(local.x) + sqr(local.y);
  return local.z > 0 ? sine2 / (1 + local.z) : 1 - local.z;
}

Vec3 EmitterScene::EmissionCone::direction(Random& random) const {
  const float height = random.unit() * height_, phi = random.between(0, 2 * kPi);
  const float r = safe_sqrt(height * (2 - height));
  return frame_.to_world(Vec3(r * std::cos(phi), r * std::sin(phi), 1 - height));
}

float EmitterScene::EmissionCone::pdf(const Vec3& d) const {
  return height_of(d) <= height_ ? 1 / (2 * kPi * height_) : 0;
}

std::optional<EmissionSample> random_emission(const Emitter& emitter, Random& random) {
  const Vec2 position = random.unit2();
  return emitter.sample_emission(position, random.unit2());
}

float ratio_of(float a, float b) {
  const float ratio = a / b;
  return std::isnan(ratio) ? kInfinity : ratio;
}

float check_ratios(std::vector<float>& ratios, const std::string& what, Outcome& outcome) {
  const auto middle = ratios.begin() + static_cast<long>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  const float ratio = *middle;
  if (!(std::abs(ratio - 1) <= 2e-3f)) outcome.fail(fmt::format(fmt::runtime(what), ratio));
  return ratio;
}

std::string cause_of(const DensityVerdict& verdict, const std::string& pdf_name) {
  const double ratio = verdict.mass / verdict.accepted;
  if (!(verdict.accepted > 0)) return "there are no samples, but " + pdf_name + " is positive";
  if (!(std::abs(ratio - 1) < 0.02)) {
    return fmt::format(
        "{} integrates to {:.3f}, but {:.3f} of the calls return a sample: it is "
        "{:.3g} times what it must be",
        pdf_name, verdict.mass, verdict.accepted, ratio);
  }
  return fmt::format(
      "samples don't follow {}: around ({:.3f}, {:.3f}, {:.3f}) are {:.2g} of the "
      "samples, expected {:.2g}",
      pdf_name, verdict.worst.x, verdict.worst.y, verdict.worst.z, verdict.worst_sampled,
      verdict.worst_expected);
}

}  // namespace kinome::check
