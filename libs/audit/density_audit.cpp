#include "audit/density_audit.h"

#include <cmath>

#include "kinome/warp.h"

namespace kinome {
namespace {

constexpr int kPairs = 16;  ///< pairs of directions per point
/// First random number; larger than those of all attempts (first_number()).
constexpr uint64_t kFirstNumber = 10000;
constexpr uint64_t kNumbersOfPair = 5;

/// Returns q / (q + p). Negative densities count as 0; find_invalid_value() reports them.
double share_of_uniform(float pdf) {
  constexpr auto q = static_cast<double>(kUniformSpherePdf);
  return q / (q + std::max(0., static_cast<double>(pdf)));
}

}  // namespace

void DensityAudit::Terms::add(const Vec3& d, double share) {
  values[0] += share;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] > 0) values[static_cast<size_t>(axis) + 1] += share;
  }
}

void DensityAudit::add_place(const Bsdf& bsdf, const AuditPlace& place) {
  for (int pair = 0; pair < kPairs; ++pair) {
    const uint64_t u = kFirstNumber + kNumbersOfPair * static_cast<uint64_t>(pair);
    const auto density = [&](const Vec3& wo) {
      return bsdf.eval_pdf(*place.si, Lobe::kAll, wo).pdf;
    };
    Terms terms;
    const auto sample = bsdf.sample(*place.si, Lobe::kAll, place.u(u), place.u2(u + 1));
    if (sample && !any(sample->lobe & Lobe::kDelta) && sample->pdf > 0) {
      terms.add(sample->wo, share_of_uniform(density(sample->wo)));
    }
    const Vec3 uniform = square_to_uniform_sphere(place.u2(u + 3));
    terms.add(uniform, share_of_uniform(density(uniform)) - 1);
    add(terms);
  }
}

void DensityAudit::add_place(const Emitter& emitter, const AuditPlace& place) {
  for (int pair = 0; pair < kPairs; ++pair) {
    const uint64_t u = kFirstNumber + kNumbersOfPair * static_cast<uint64_t>(pair);
    Terms terms;
    const auto sample = emitter.sample_direct(place.p(), place.u2(u));
    if (sample && sample->pdf > 0) {
      terms.add(sample->d, share_of_uniform(emitter.pdf_environment(sample->d)));
    }
    const Vec3 uniform = square_to_uniform_sphere(place.u2(u + 2));
    terms.add(uniform, share_of_uniform(emitter.pdf_environment(uniform)) - 1);
    add(terms);
  }
}

void DensityAudit::add(const Terms& pair) {
  ++count_;
  for (size_t f = 0; f < kFunctions; ++f) {
    sums_[f] += pair.values[f];
    squares_[f] += pair.values[f] * pair.values[f];
  }
}

void DensityAudit::add(const DensityAudit& other) {
  count_ += other.count_;
  for (size_t f = 0; f < kFunctions; ++f) {
    sums_[f] += other.sums_[f];
    squares_[f] += other.squares_[f];
  }
}

bool DensityAudit::fails() const {
  if (count_ < 2) return false;
  // Each of the four means exceeds its bound, to either side, with probability 1e-9 / 8.
  const double log_rate = std::log(2 * 8 / 1e-9);
  constexpr double kRange = 2;  // range of a difference of two shares
  const auto n = static_cast<double>(count_);
  for (size_t f = 0; f < kFunctions; ++f) {
    const double mean = sums_[f] / n;
    const double variance = std::max(0., squares_[f] / n - mean * mean) * n / (n - 1);
    const double bound =
        std::sqrt(2 * variance * log_rate / n) + 7 * kRange * log_rate / (3 * (n - 1));
    if (std::abs(mean) > bound) return true;
  }
  return false;
}

}  // namespace kinome
