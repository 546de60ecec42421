#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "kinome/blocks.h"

/// Blocks of rows of numpy arrays, as columns for the functions of plugins.
namespace kinome::python {

namespace nb = nanobind;

inline constexpr size_t kRowsPerBlock = 2048;

/// Columns of SurfaceBlock with three values per point.
inline constexpr Columns3 SurfaceBlock::* kTripleColumns[] = {
    &SurfaceBlock::p,  &SurfaceBlock::n,     &SurfaceBlock::s,     &SurfaceBlock::t,
    &SurfaceBlock::sn, &SurfaceBlock::dp_du, &SurfaceBlock::dp_dv, &SurfaceBlock::wi};
inline constexpr size_t kTriples = std::size(kTripleColumns);

inline Vec3 row3(const float* values, size_t row) {
  return {values[3 * row], values[3 * row + 1], values[3 * row + 2]};
}
inline void set_row3(std::vector<float>& values, size_t row, const Vec3& v) {
  values[3 * row] = v.x, values[3 * row + 1] = v.y, values[3 * row + 2] = v.z;
}

/// Columns for `count` values, initialized to 0.
class Columns {
 public:
  explicit Columns(size_t count) : vectors_(padded(count) / kBlockLanes) {}
  Columns(const Columns&) = delete;
  Columns& operator=(const Columns&) = delete;

  float* one() { return allocate<float>(); }
  Columns2 two() { return {one(), one()}; }
  Columns3 three() { return {one(), one(), one()}; }
  SurfaceBlock points(size_t count) {
    SurfaceBlock points;
    points.count = count;
    for (const auto column : kTripleColumns) points.*column = three();
    points.uv = two();
    points.p_error = one();
    points.primitive = allocate<uint32_t>(), points.ray = allocate<uint32_t>();
    points.shape = allocate<const Shape*>();
    return points;
  }

 private:
  template <class T>
  T* allocate() {
    struct alignas(kColumnAlignment) Lanes {
      T values[kBlockLanes];
    };
    auto* const lanes = new Lanes[vectors_]();
    memory_.emplace_back(lanes, [](void* memory) { delete[] static_cast<Lanes*>(memory); });
    return lanes[0].values;
  }

  size_t vectors_;
  std::vector<std::shared_ptr<void>> memory_;
};

/// Reads rays from rows of 8 numbers: origin, minimum t, direction, maximum t.
inline Ray read_ray(const float* rays, size_t row) {
  const float* const values = rays + 8 * row;
  return {{values[0], values[1], values[2]}, {values[4], values[5], values[6]}, values[3], values[7]};
}
inline void write_ray(std::vector<float>& rays, size_t row, const Ray& ray) {
  float* const values = &rays[8 * row];
  for (int axis = 0; axis < 3; ++axis) values[axis] = ray.o[axis], values[4 + axis] = ray.d[axis];
  values[3] = ray.tmin, values[7] = ray.tmax;
}
/// Reads the rays first, first + 1, …. The padding is disabled.
inline void read_rays(const float* rays, size_t first, size_t count, std::vector<Ray16>& block) {
  for (Ray16& lanes : block) reset(lanes);
  for (size_t i = 0; i < count; ++i) {
    set_ray(block[i / kBlockLanes], i % kBlockLanes, read_ray(rays, first + i));
  }
  disable_padding(block.data(), count);
}
/// Same for rays with hits, which are cleared.
inline void read_rays(const float* rays, size_t first, size_t count, std::vector<RayHit16>& block) {
  for (RayHit16& lanes : block) {
    reset(lanes.ray);
    std::ranges::fill(lanes.shape, kNoHit);
    std::ranges::fill(lanes.instance, kNoHit);
  }
  for (size_t i = 0; i < count; ++i) {
    set_ray(block[i / kBlockLanes].ray, i % kBlockLanes, read_ray(rays, first + i));
  }
  disable_padding(block.data(), count);
}

/// Calls fn(first, count) for blocks of rows, on all cores, without the interpreter's lock.
/// Rethrows the first exception.
template <class Function>
void for_each_block(size_t rows, const Function& fn) {
  const size_t blocks = (rows + kRowsPerBlock - 1) / kRowsPerBlock;
  std::atomic<size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr fault;
  const auto work = [&] {
    try {
      for (size_t block; (block = next++) < blocks;) {
        const size_t first = block * kRowsPerBlock;
        fn(first, std::min(kRowsPerBlock, rows - first));
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!fault) fault = std::current_exception();
      next = blocks;
    }
  };
  {
    const nb::gil_scoped_release release;
    std::vector<std::jthread> threads;
    const size_t cores = std::max(1u, std::thread::hardware_concurrency());
    for (size_t i = 1; i < std::min(cores, blocks); ++i) threads.emplace_back(work);
    work();
  }
  if (fault) std::rethrow_exception(fault);
}

}  // namespace kinome::python
