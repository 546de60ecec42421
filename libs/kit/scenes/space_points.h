#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "kinome/volume.h"
#include "kit/plan.h"
#include "kit/scenes/block_memory.h"
#include "kit/statistics/random.h"

/// Points and segments in space, for the checks of volumes and media.
namespace kinome::check {

/// Returns the part of a medium's or volume's box to test: a cube if the box is infinite or empty.
inline Aabb tested_box(const Aabb& box) {
  const bool is_usable = !box.empty() && is_finite(box.lo) && is_finite(box.hi);
  return is_usable ? box : Aabb(Vec3(-1.f), Vec3(1.f));
}

inline Vec3 point_in(const Aabb& box, Random& random) {
  const Vec2 xy = random.unit2();
  return glm::mix(box.lo, box.hi, Vec3(xy, random.unit()));
}

inline std::string at_point(const Vec3& p) {
  return fmt::format(", at ({}, {}, {})", p.x, p.y, p.z);
}

inline bool are_close(float a, float b, float scale) {
  return std::abs(a - b) <= 1e-4f * scale + 1e-30f;
}

/// Segments o + t d in a box, 0 <= t <= length.
struct BoxSegments {
  Columns3 o, d;
  float* length;

  BoxSegments(BlockMemory& memory, const Aabb& box, size_t count, Random& random)
      : o(memory.three()), d(memory.three()), length(memory.one()) {
    for (size_t i = 0; i < count; ++i) {
      const Vec3 a = point_in(box, random), to = point_in(box, random) - a;
      length[i] = glm::length(to);
      o.set(i, a);
      d.set(i, length[i] > 0 ? to / length[i] : Vec3(1, 0, 0));
    }
  }
};

/// Compares an integral along a segment with the midpoint rule: returns whether they agree up to
/// the rule's error.
template <class Value>
bool is_integral(float stated, const BoxSegments& segments, size_t i, float max,
                 const Value& value) {
  constexpr int kSteps = 1000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const float t = segments.length[i] * (static_cast<float>(k) + 0.5f) / kSteps;
    sum += double{value(segments.o.at(i) + segments.d.at(i) * t)};
  }
  const double expected = sum * double{segments.length[i]} / kSteps;
  return std::abs(stated - expected) <= 5e-3 * double{max} * double{segments.length[i]} + 1e-30;
}

/// Tests bounds in a grid of blocks: calls value(p, fail) at points of each block.
template <class Extremes, class Range>
Outcome check_extremes(const Aabb& box, uint64_t seed, const Extremes& extremes,
                       const Range& range_at) {
  Outcome outcome;
  Random random(seed);
  const Vec3 size = box.extent();
  // Larger than the box, because blocks may be anywhere.
  const BlockGrid blocks{{box.lo - 0.1f * size, box.hi + 0.1f * size}, {5, 3, 4}};
  std::vector<float> lo(blocks.count(), kNan), hi(blocks.count(), kNan);
  extremes(blocks, lo.data(), hi.data());
  size_t i = 0;
  for (glm::uvec3 at(0); at.z < blocks.size.z; ++at.z) {
    for (at.y = 0; at.y < blocks.size.y; ++at.y) {
      for (at.x = 0; at.x < blocks.size.x; ++at.x, ++i) {
        for (int k = 0; k < 200; ++k) {
          const Vec3 p = point_in(blocks.block(at), random);
          const auto [least, most] = range_at(p, random);
          if (least >= lo[i] && most <= hi[i]) continue;
          outcome.fail(
              fmt::format("extremes() returns {:.6g} to {:.6g} for a block with the "
                          "values {:.6g} to {:.6g}{}",
                          lo[i], hi[i], least, most, at_point(p)));
        }
      }
    }
  }
  outcome.measured = fmt::format("200 points in each of {} blocks", blocks.count());
  return outcome;
}

}  // namespace kinome::check
