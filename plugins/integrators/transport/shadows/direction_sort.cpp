#include "transport/shadows/direction_sort.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

DirectionSort::DirectionSort(size_t rays)
    : arena_(rays),
      bin_(arena_.indices()),
      order_(arena_.indices()),
      rows_arena_(4 * padded(rays)),
      from_(rows_arena_.floats()),
      along_(rows_arena_.floats()) {}

size_t DirectionSort::sort(const Ray16* rays, size_t count) {
  constexpr float kHalf = kSide / 2.f;
  for_lanes(count, [&](size_t i) {
    const Ray16& r = rays[i / kBlockLanes];
    const size_t lane = i % kBlockLanes;
    const Float x = Float::load(r.dx + lane), y = Float::load(r.dy + lane),
                z = Float::load(r.dz + lane);
    const Float scale = 1.f / (abs(x) + abs(y) + abs(z));
    const Float px = x * scale, py = y * scale;
    const Mask below = z < 0.f;
    const Float u = select(below, copysign(1.f - abs(py), px), px);
    const Float v = select(below, copysign(1.f - abs(px), py), py);
    const auto side = [&](Float c) {
      return clamp(to_int(mul_add(c, Float(kHalf), Float(kHalf))), Int(0),
                   Int(static_cast<int32_t>(kSide) - 1));
    };
    const Float tmax = Float::load(r.tmax + lane);
    store_rows(Float::load(r.ox + lane), Float::load(r.oy + lane), Float::load(r.oz + lane), tmax,
               from_ + 4 * i);
    store_rows(x, y, z, x, along_ + 4 * i);
    const Mask on = tmax >= 0.f;
    select(on, side(v) * Int(static_cast<int32_t>(kSide)) + side(u),
           Int(static_cast<int32_t>(kBins)))
        .store(bin_ + i);
  });
  // Neighbours often have the same bin, and each increment would wait for the one before. Counting
  // the two halves alternately hides this latency.
  const size_t half = count / 2;
  auto& [low, high] = next_;
  low.fill(0), high.fill(0);
  for (size_t i = 0; i < half; ++i) ++low[bin_[i]], ++high[bin_[half + i]];
  if (count % 2 != 0) ++high[bin_[count - 1]];
  uint32_t next = 0;
  for (uint32_t bin = 0; bin < kBins; ++bin) {
    next += std::exchange(low[bin], next);
    next += std::exchange(high[bin], next);
  }
  on_ = next;
  high[kBins] = next + std::exchange(low[kBins], next);
  for (size_t i = 0; i < half; ++i) {
    order_[low[bin_[i]]++] = static_cast<uint32_t>(i);
    order_[high[bin_[half + i]]++] = static_cast<uint32_t>(half + i);
  }
  if (count % 2 != 0) order_[high[bin_[count - 1]]++] = static_cast<uint32_t>(count - 1);
  if (on_ > 0) std::fill(order_ + on_, order_ + padded(on_), order_[on_ - 1]);
  return on_;
}

void DirectionSort::copy(Ray16* to, size_t stride) const {
  const auto block = [&](size_t k) -> Ray16& {
    return *reinterpret_cast<Ray16*>(reinterpret_cast<char*>(to) + k * stride);
  };
  for_lanes(on_, [&](size_t i) {
    alignas(kColumnAlignment) float from[4 * kLanes], along[4 * kLanes];
    for (size_t l = 0; l < kLanes; ++l) {
      std::memcpy(from + 4 * l, from_ + 4 * size_t{order_[i + l]}, 4 * sizeof(float));
      std::memcpy(along + 4 * l, along_ + 4 * size_t{order_[i + l]}, 4 * sizeof(float));
    }
    Float ox, oy, oz, tmax, dx, dy, dz, unused;
    load_rows(from, ox, oy, oz, tmax);
    load_rows(along, dx, dy, dz, unused);
    Ray16& rays = block(i / kBlockLanes);
    const size_t lane = i % kBlockLanes;
    ox.store(rays.ox + lane), oy.store(rays.oy + lane), oz.store(rays.oz + lane);
    dx.store(rays.dx + lane), dy.store(rays.dy + lane), dz.store(rays.dz + lane);
    tmax.store(rays.tmax + lane);
  });
  for (size_t i = on_; i < padded(on_); ++i) block(i / 16).tmax[i % 16] = -1;
}

}  // namespace kinome::transport
