#pragma once

#include <array>

#include "kinome/wide/bsdf.h"
#include "kinome/wide/fresnel.h"
#include "kinome/wide/microfacet.h"

namespace kinome {

using namespace wide::formulas;

/// Transmittance of a rough dielectric boundary above a diffuse layer: the fraction of light from
/// one direction that enters, and the fraction of diffuse light inside that is reflected back.
/// Computed at load time by Gauss-Legendre quadrature over the unit square of visible normal
/// sampling, on Mitsuba 3's grid of cosines.
class RoughTransmittance {
 public:
  RoughTransmittance(MicrofacetType type, float alpha, float eta);

  /// Fraction of light at cos_theta in [0, 1] that enters from outside.
  template <class F>
  F external(const F& cos_theta) const {
    return tabulated(external_.data(), cos_theta);
  }
  /// Values of external() at cosines k / (size - 1).
  const auto& table() const { return external_; }
  /// Fraction of cosine-distributed light inside that is reflected back inside.
  float internal_reflectance() const { return internal_reflectance_; }

 private:
  static constexpr int kSize = BsdfForm::kTableSize;
  static constexpr int kOutsideNodes = 32;
  static constexpr int kInsideNodes = 128;  // with 48, images were 0.009 % too dark
  std::array<float, kSize> external_;
  float internal_reflectance_ = 0;
};

namespace rough_transmittance_detail {

/// Nodes and weights of Gauss-Legendre quadrature on [0, 1], by Newton's method on P_n.
template <int kNodes>
struct Quadrature {
  std::array<float, kNodes> node;
  std::array<float, kNodes> weight;

  Quadrature() {
    for (int i = 0; i < kNodes; ++i) {
      double x = std::cos(std::numbers::pi * (i + 0.75) / (kNodes + 0.5));
      double slope = 1;
      for (int step = 0; step < 8; ++step) {
        double p = 1, previous = 0;
        for (int n = 0; n < kNodes; ++n) {
          const double next = ((2 * n + 1) * x * p - n * previous) / (n + 1);
          previous = p;
          p = next;
        }
        slope = kNodes * (x * p - previous) / (x * x - 1);
        x -= p / slope;
      }
      node[i] = static_cast<float>(0.5 * (1 - x));
      weight[i] = static_cast<float>(1 / ((1 - x * x) * slope * slope));
    }
  }
};

/// Integrates f(wi, m) over the visible normals m of an isotropic distribution.
template <MicrofacetType kType, int kNodes>
class VisibleNormalIntegral {
 public:
  explicit VisibleNormalIntegral(float alpha) : microfacet_(alpha, alpha), alpha_(alpha) {
    for (int j = 0; j < kNodes; ++j) {
      slope_y_[j] = beckmann_slope_y(quadrature_.node[j]);
    }
  }

  template <class Fn>
  float operator()(float cos_i, const Fn& f) const {
    const Vec3 wi(safe_sqrt(1 - cos_i * cos_i), 0, cos_i);
    const Vec2 w = glm::normalize(Vec2(alpha_ * wi.x, wi.z));
    // The integrand is symmetric about the plane of incidence: half of the azimuth's nodes suffice.
    float sum = 0;
    for (int i = 0; i < kNodes; ++i) {
      float slope_x = 0;
      if constexpr (kType == MicrofacetType::kBeckmann) {
        // The two slopes are independent, so each is inverted once per node and not per pair.
        slope_x = beckmann_visible_slope_x(w.y, w.x, quadrature_.node[i]);
      }
      for (int j = 0; j < kNodes / 2; ++j) {
        Vec3 m;
        if constexpr (kType == MicrofacetType::kBeckmann) {
          m = glm::normalize(Vec3(-alpha_ * slope_x, -alpha_ * slope_y_[j], 1.f));
        } else {
          m = microfacet_.sample_visible(wi, Vec2(quadrature_.node[j], quadrature_.node[i]));
        }
        sum += quadrature_.weight[i] * quadrature_.weight[j] * f(wi, m);
      }
    }
    return 2 * sum;
  }

 private:
  Quadrature<kNodes> quadrature_;
  Microfacet<kType> microfacet_;
  float alpha_;
  std::array<float, kNodes> slope_y_;
};

}  // namespace rough_transmittance_detail

inline RoughTransmittance::RoughTransmittance(MicrofacetType type, float alpha, float eta) {
  namespace detail = rough_transmittance_detail;
  alpha = std::max(alpha, kMinAlpha);
  with_microfacet_type(type, [&](auto type_constant) {
    constexpr MicrofacetType kType = decltype(type_constant)::value;
    const Microfacet<kType> microfacet(alpha, alpha);
    const auto transmitted = [&](const Vec3& wi, const Vec3& m) {
      const float cos_i = glm::dot(wi, m);
      const float cos_t = safe_sqrt(1 - (1 - cos_i * cos_i) / (eta * eta));
      const Vec3 wo = (cos_i / eta - cos_t) * m - wi / eta;
      return wo.z < 0 ? microfacet.smith_g1(-wo) * (1 - fresnel_dielectric(cos_i, eta)) : 0.f;
    };
    const auto reflected_inside = [&](const Vec3& wi, const Vec3& m) {
      const float cos_i = glm::dot(wi, m);
      const Vec3 wo = mirrored_at(wi, m);
      return wo.z > 0 ? microfacet.smith_g1(wo) * fresnel_dielectric(cos_i, 1 / eta) : 0.f;
    };
    // The integrand inside is less smooth because of total reflection, so it needs more nodes.
    const detail::VisibleNormalIntegral<kType, kOutsideNodes> outside(alpha);
    const detail::VisibleNormalIntegral<kType, kInsideNodes> inside(alpha);
    float sum = 0;
    for (int i = 0; i < kSize; ++i) {
      const float mu = std::max(static_cast<float>(i) / (kSize - 1), 1e-6f);
      external_[i] = outside(mu, transmitted);
      sum += inside(mu, reflected_inside) * mu;
    }
    internal_reflectance_ = 2 * sum / kSize;
  });
}

}  // namespace kinome
