#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include "kinome/blocks.h"
#include "transport/blocks/arena_memory.h"

namespace kinome::transport {

/// Calls fn(from, to) for the pointers to each column of two blocks of points.
template <class Function>
void for_each_column(const SurfaceBlock& from, const SurfaceBlock& to, const Function& fn) {
  for (Columns3 SurfaceBlock::*const three :
       {&SurfaceBlock::p, &SurfaceBlock::n, &SurfaceBlock::s, &SurfaceBlock::t, &SurfaceBlock::sn,
        &SurfaceBlock::dp_du, &SurfaceBlock::dp_dv, &SurfaceBlock::wi}) {
    const Columns3 &a = from.*three, &b = to.*three;
    fn(a.x, b.x), fn(a.y, b.y), fn(a.z, b.z);
  }
  fn(from.uv.x, to.uv.x), fn(from.uv.y, to.uv.y), fn(from.p_error, to.p_error);
  fn(from.primitive, to.primitive), fn(from.ray, to.ray), fn(from.shape, to.shape);
}

/// Columns (columns.h) of equal capacity, which live as long as the arena. A stage allocates its
/// columns once per thread and uses them for every block. They are initialised to zero. The unused
/// part of a long column takes addresses but no physical memory, so capacities may be those of the
/// worst case.
class Arena {
 public:
  explicit Arena(size_t capacity) : capacity_(padded(capacity)) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  size_t capacity() const { return capacity_; }
  float* floats() { return allocate<float>(capacity_); }
  uint32_t* indices() { return allocate<uint32_t>(capacity_); }
  Columns2 two() { return {floats(), floats()}; }
  Columns3 three() { return {floats(), floats(), floats()}; }
  template <class T>
  T* of() {
    return allocate<T>(capacity_);
  }
  /// Allocates all columns of a block of surface points.
  SurfaceBlock points() {
    SurfaceBlock points;
    for (Columns3* const columns : {&points.p, &points.n, &points.s, &points.t, &points.sn,
                                    &points.dp_du, &points.dp_dv, &points.wi}) {
      *columns = three();
    }
    points.uv = two();
    points.p_error = floats();
    points.primitive = indices(), points.ray = indices();
    points.shape = of<const Shape*>();
    return points;
  }
  /// Allocates blocks of 16 rays for `capacity` rays. Masks and times are set.
  Ray16* rays() {
    Ray16* const rays = allocate<Ray16>(capacity_ / 16, false);
    for (size_t i = 0; i < capacity_ / 16; ++i) reset(rays[i]);
    return rays;
  }
  /// Allocates blocks of rays that are copied but never traced. Masks are not set.
  Ray16* untraced_rays() { return allocate<Ray16>(capacity_ / 16); }
  RayHit16* ray_hits() {
    RayHit16* const rays = allocate<RayHit16>(capacity_ / 16, false);
    for (size_t i = 0; i < capacity_ / 16; ++i) reset(rays[i].ray);
    return rays;
  }

 private:
  struct GiveBack {
    void operator()(void* memory) const { ArenaMemory::give_back(memory); }
  };
  /// `is_sparse`: blocks may use only the beginning of the memory.
  template <class T>
  T* allocate(size_t count, bool is_sparse = true) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::unique_ptr<void, GiveBack> memory(ArenaMemory::take(count * sizeof(T), is_sparse));
    memory_.push_back(std::move(memory));
    return static_cast<T*>(memory_.back().get());
  }

  size_t capacity_;
  std::vector<std::unique_ptr<void, GiveBack>> memory_;
};

}  // namespace kinome::transport
