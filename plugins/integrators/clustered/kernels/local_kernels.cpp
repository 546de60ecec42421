#include "clustered/kernels/local_kernels.h"

#include "clustered/kernels/vector_columns.h"

namespace kinome::simd {
namespace {

using wide::Float;
using wide::Mask;
using wide::Vec3;

constexpr size_t kRow = sizeof(LightPointRow) / sizeof(float);
constexpr size_t kPower = offsetof(LightPointRow, power) / sizeof(float);
constexpr size_t kEyeRatio = offsetof(LightPointRow, eye_ratio) / sizeof(float);

}  // namespace

void gather_points(const LightPointRow* rows, const PickedRows& picks, size_t count,
                   float* const (&columns)[kLightPointNumbers]) {
  if (count == 0) return;  // There may be no rows.
  const float* const numbers = rows->position;
  wide::for_lanes(count, [&](size_t i) {
    const wide::Int first = wide::Int::load(picks.index + i) * static_cast<int32_t>(kRow);
    const auto copy = [&](size_t begin, size_t end, Float factor) {
      for (size_t k = begin; k < end; ++k) {
        (wide::gather(numbers + k, first) * factor).store(columns[k] + i);
      }
    };
    copy(0, kPower, 1.f);
    copy(kPower, kEyeRatio, Float::load(picks.weight + i));
    copy(kEyeRatio, kLightPointNumbers, Float::load(picks.eye_weight + i));
  });
}

void connect_points(const LightPointColumns& points, const SurfacePoint& from, size_t count,
                    const ConnectionColumns& out) {
  const Vec3 position(from.position[0], from.position[1], from.position[2]);
  const Vec3 plane(from.geometric[0], from.geometric[1], from.geometric[2]);
  wide::for_lanes(count, [&](size_t i) {
    const Vec3 to = load(points.position, i) - position;
    const Float height = abs(dot(to, plane));
    const Float distance = length(to);
    const Float inverse = 1.f / max(distance, 1e-18f);
    const Vec3 d = to * inverse;
    const Mask faces = dot(load(points.normal, i), d) < 0.f && height > from.error;
    const Float geometry = abs(dot(load(points.geometric, i), d)) * (inverse * inverse);
    (load(points.power, i) * select(faces, geometry)).store_interleaved(out.radiance + 3 * i);
    (Float::load(points.eye_ratio + i) * geometry).store(out.eye_ratio + i);
    d.store({out.dx, out.dy, out.dz}, i);
    distance.store(out.distance + i);
  });
}

}  // namespace kinome::simd
