#include "kinome/sphere_partition.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinome/error.h"

namespace kinome {
namespace {

constexpr double kTau = 2 * std::numbers::pi;

/// Bound on the error of a coordinate of a unit vector of floats, including the rounding errors of
/// direction() and cell_of().
constexpr double kRounding = 0x1p-22;

/// Moves u away from the ends of [0, 1] by `margin`, so that rounding can't move it out of a cell.
double inside(float u, double margin) {
  const double m = std::min(margin, 0.5);
  return std::clamp(static_cast<double>(u), m, 1 - m);
}

}  // namespace

SpherePartition::SpherePartition(uint32_t size) : size_(size) {
  if (size == 0) throw Error("a sphere partition needs at least one cell");
  // Choose the number of rings such that a ring is as high as a square cell of this area. Move the
  // borders of the rings to whole cells, so that all areas are equal. This is the idea of Leopardi
  // 2006, with wedges instead of his polar caps.
  const double side = std::sqrt(2 * kTau / size);
  const auto rings = std::max(1L, std::lround(std::numbers::pi / side));
  first_.push_back(0);
  for (long r = 1; r < rings; ++r) {
    const double theta = std::numbers::pi * static_cast<double>(r) / static_cast<double>(rings);
    const double north = 0.5 * size * (1 - std::cos(theta));
    const auto cell = static_cast<uint32_t>(std::lround(north));
    if (cell > first_.back() && cell < size) first_.push_back(cell);
  }
  first_.push_back(size);
}

uint32_t SpherePartition::ring_of(uint32_t cell) const {
  const auto after = std::upper_bound(first_.begin(), first_.end() - 1, cell);
  return static_cast<uint32_t>(after - first_.begin()) - 1;
}

Vec3 SpherePartition::direction(double turn, double north) const {
  const double share = north / size_;  // (1 - cos theta) / 2, accurate near the pole
  const double sin_theta = 2 * std::sqrt(std::max(0.0, share * (1 - share)));
  const double phi = kTau * turn;
  return Vec3(std::sin(phi) * sin_theta, 1 - 2 * share, -std::cos(phi) * sin_theta);
}

Vec3 SpherePartition::centre(uint32_t i) const {
  const uint32_t ring = ring_of(i);
  const uint32_t in_ring = first_[ring + 1] - first_[ring];
  return direction((i - first_[ring] + 0.5) / in_ring, first_[ring] + 0.5 * in_ring);
}

Vec3 SpherePartition::sample(uint32_t i, const Vec2& u) const {
  const uint32_t ring = ring_of(i);
  const double in_ring = first_[ring + 1] - first_[ring];
  // Rounding moves phi by up to kRounding radians, and changes the number of cells up to the nearer
  // pole by a factor of up to 1 + kRounding. The margins are relative to a cell's extents.
  const double to_pole = std::min(first_[ring + 1], size_ - first_[ring]);
  const double turn = inside(u.x, kRounding * in_ring);
  const double height = inside(u.y, kRounding * to_pole / in_ring);
  return direction((i - first_[ring] + turn) / in_ring, first_[ring] + height * in_ring);
}

uint32_t SpherePartition::cell_of(const Vec3& d) const {
  // Compute 1 - |cos theta| from the sine, which is accurate near the poles.
  const double x = d.x, y = d.y, z = d.z;
  const double sin2 = x * x + z * z;
  const double cap = sin2 / (sin2 + y * y + std::abs(y) * std::sqrt(sin2 + y * y));
  const double north = 0.5 * size_ * (y >= 0 ? cap : 2 - cap);
  const auto nearest = static_cast<uint32_t>(std::clamp(north, 0.0, size_ - 1.0));
  const uint32_t ring = ring_of(nearest);
  const uint32_t in_ring = first_[ring + 1] - first_[ring];
  double turn = std::atan2(x, -z) / kTau;
  if (turn < 0) turn += 1;
  return first_[ring] + std::min(static_cast<uint32_t>(turn * in_ring), in_ring - 1);
}

}  // namespace kinome
