#include "clustered/media/lamp_guide.h"

#include <algorithm>
#include <cmath>

#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

/// Part of the directions that the guide draws; the phase function draws the others.
constexpr float kGuidedShare = 0.5f;
/// Minimum of sin(θ/2), against division by 0.
constexpr float kMinSine = 1e-7f;

}  // namespace

LampGuide::LampGuide(const FogSources& sources)
    : count_(sources.near().size()),
      arena_(std::max<size_t>(1, count_)),
      p_(arena_.three()),
      intensity_(arena_.floats()),
      radius2_(arena_.floats()),
      weight_(arena_) {
  std::fill_n(radius2_, arena_.capacity(), 1.f);
  for (size_t i = 0; i < count_; ++i) {
    const FogSources::Near& near = sources.near()[i];
    p_.set(i, near.p);
    intensity_[i] = near.intensity;
    radius2_[i] = std::max(near.radius * near.radius, 1e-20f);
  }
}

float LampGuide::light_at(const Vec3& p) {
  using namespace wide;
  weight_.clear();
  weight_.add(0, count_, [&](size_t i) {
    const wide::Vec3 to = wide::Vec3::load(p_, i) - wide::Vec3(p);
    return Float::load(intensity_ + i) / sqrt(max(dot(to, to), Float::load(radius2_ + i)));
  });
  return weight_.total();
}

float LampGuide::density(const Vec3& p, const Vec3& d) const {
  using namespace wide;
  Float sum(0.f);
  for_lanes(count_, [&](size_t i) {
    const wide::Vec3 to = wide::Vec3::load(p_, i) - wide::Vec3(p);
    const wide::Vec3 beside = to / sqrt(max(dot(to, to), Float(1e-30f))) - wide::Vec3(d);
    const Float sine = 0.5f * sqrt(dot(beside, beside));
    sum = sum + Float::load(weight_.weights() + i) / max(sine, Float(kMinSine));
  });
  return wide::sum(sum) / (8 * kPi * weight_.total());
}

float LampGuide::redirect(const Phase& phase, const MediumPoint& point, float u1, const Vec2& u2,
                          Vec3& wo, float& pdf) {
  if (!(pdf > 0)) return 0;
  const float light = light_at(point.p);
  if (!(light > 0) || !(light < kInfinity)) return 1;
  if (u1 < kGuidedShare) {
    const Vec3 to = p_.at(weight_.at(u1 / kGuidedShare * light)) - point.p;
    const float sine = u2.x, cosine = 1 - 2 * sine * sine;  // of θ/2 and θ
    const float across = 2 * sine * std::sqrt(std::max(0.f, 1 - sine * sine)), phi = 2 * kPi * u2.y;
    const Frame frame = Frame::from_normal(glm::normalize(to));
    const Vec3 d = frame.to_world({across * std::cos(phi), across * std::sin(phi), cosine});
    wo = glm::normalize(point.frame.to_local(d));
    pdf = phase.eval(point, wo);
  }
  const float guided = density(point.p, point.frame.to_world(wo));
  return pdf / ((1 - kGuidedShare) * pdf + kGuidedShare * guided);
}

}  // namespace kinome
