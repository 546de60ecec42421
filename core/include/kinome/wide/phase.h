#pragma once

// Phase functions that depend only on the angle of deflection. Their formulas are written once, for
// single points and for blocks.

#include "kinome/phase.h"
#include "kinome/wide/functions.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Cosine c of a deflection, as 1 - c and 1 + c. Both have small relative errors, also for the
/// narrow peaks of phase functions near c = 1 and c = -1.
template <class F>
struct Deflection {
  F minus, plus;

  /// Deflection of the light that arrives along -wo and leaves along wi = (0, 0, 1), or reversed.
  static Deflection of(const VecOf<F>& wo) {
    using plain::select;
    const F sine2 = wo.x * wo.x + wo.y * wo.y;
    const auto is_forward = wo.z < 0.f;
    const F large = 1.f + select(is_forward, -wo.z, wo.z);
    const F small = sine2 / large;
    return {select(is_forward, small, large), select(is_forward, large, small)};
  }
  /// Direction wo with the azimuth 2 pi u.
  VecOf<F> direction(const F& u) const {
    using std::max, std::sqrt;
    F sine, cosine;
    sincos(F(2 * kPi) * u, sine, cosine);
    const F r = sqrt(max(minus * plus, F(0.f)));
    return {r * cosine, r * sine, 0.5f * (minus - plus)};
  }
};

inline namespace formulas {

/// Henyey-Greenstein function for |g| < 1 [1/sr]. Light is scattered forward if g is positive.
template <class F>
F henyey_greenstein(const F& g, const Deflection<F>& at) {
  using plain::select, std::abs, std::sqrt;
  // (1 - |g|)² + 2 |g| (1 - c sign(g)): all terms are positive.
  const F a = abs(g), near = 1.f - a;
  const F d = near * near + 2.f * a * select(g > 0.f, at.minus, at.plus);
  return near * (1.f + a) * F(0.25f * kInvPi) / (d * sqrt(d));
}
/// Samples henyey_greenstein(). With v = 1 - u and d = (1 - g) v + (1 + g) u, the inverse of the
/// distribution function is
///     1 - c = 2 ((1 - g) / d)² v (1 + g u),  1 + c = 2 ((1 + g) / d)² u (1 - g v).
/// This form, unlike the usual one, has no division by g. The last factors are written as sums of
/// positive terms.
template <class F>
Deflection<F> sample_henyey_greenstein(const F& g, const F& u) {
  using plain::select;
  const F v = 1.f - u;
  const F d = (1.f - g) * v + (1.f + g) * u;
  const F behind = (1.f - g) / d, ahead = (1.f + g) / d;
  const auto is_forward = g > 0.f;
  return {2.f * behind * behind * v * select(is_forward, 1.f + g * u, (1.f + g) - g * v),
          2.f * ahead * ahead * u * select(is_forward, (1.f - g) + g * u, 1.f - g * v)};
}

}  // namespace formulas

/// Base class of phase functions that depend only on the deflection, written as formulas over a
/// number type F, float or Float. Self has
///
///     template <class F>
///     F value(const Deflection<F>& at) const;      // [1/sr]
///     template <class F>
///     Deflection<F> draw(const F& u) const;        // with the density 2 pi value()
template <class Self>
class DeflectionPhase : public Phase {
 public:
  float eval(const MediumPoint& /*point*/, const glm::vec3& wo) const override {
    return self().template value<float>(Deflection<float>::of(wo));
  }
  PhaseSample sample(const MediumPoint& /*point*/, float /*u1*/,
                     const glm::vec2& u2) const override {
    const auto drawn = self().template draw<float>(u2.x);
    return {drawn.direction(u2.y), self().template value<float>(drawn)};
  }
  void eval_block(const MediumPointBlock& points, const Columns3& wo, float* value) const override {
    for_lanes(points.count, [&](size_t i) {
      self().template value<Float>(Deflection<Float>::of(Vec3::load(wo, i))).store(value + i);
    });
  }
  void sample_block(const MediumPointBlock& points, const float* /*u1*/, const Columns2& u2,
                    const Columns3& wo, float* pdf) const override {
    for_lanes(points.count, [&](size_t i) {
      const Vec2 u = Vec2::load(u2, i);
      const auto drawn = self().template draw<Float>(u.x);
      drawn.direction(u.y).store(wo, i);
      self().template value<Float>(drawn).store(pdf + i);
    });
  }

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }
};

/// The phase function henyey_greenstein().
class HenyeyGreensteinPhase : public DeflectionPhase<HenyeyGreensteinPhase> {
 public:
  /// Requires |g| < 1.
  explicit HenyeyGreensteinPhase(float g) : g_(g) {}

  template <class F>
  F value(const Deflection<F>& at) const {
    return henyey_greenstein(F(g_), at);
  }
  template <class F>
  Deflection<F> draw(const F& u) const {
    return sample_henyey_greenstein(F(g_), u);
  }

  std::array<HgLobe, 2> lobes() const override { return {HgLobe{g_, 1}, HgLobe{g_, 0}}; }

 private:
  float g_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
