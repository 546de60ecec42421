#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "kinome/blocks.h"

namespace kinome::transport {

/// Columns (columns.h) of one capacity, which live as long as the arena: a stage makes its own once
/// a thread, and uses them for every block. They begin as zeros.
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
  /// As many blocks of 16 rays as `capacity` rays take; masks and times are set.
  Ray16* rays() {
    Ray16* const rays = allocate<Ray16>(capacity_ / 16);
    for (size_t i = 0; i < capacity_ / 16; ++i) reset(rays[i]);
    return rays;
  }
  RayHit16* ray_hits() {
    RayHit16* const rays = allocate<RayHit16>(capacity_ / 16);
    for (size_t i = 0; i < capacity_ / 16; ++i) reset(rays[i].ray);
    return rays;
  }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(void* memory) const { ::operator delete(memory, kAlignment); }
  };
  template <class T>
  T* allocate(size_t count) {
    void* const memory = ::operator new(count * sizeof(T), kAlignment);
    memory_.emplace_back(memory);
    T* const values = static_cast<T*>(memory);
    std::uninitialized_value_construct_n(values, count);
    return values;
  }

  size_t capacity_;
  std::vector<std::unique_ptr<void, Free>> memory_;
};

}  // namespace kinome::transport
