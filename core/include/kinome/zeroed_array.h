#pragma once

#include <limits>
#include <new>
#include <type_traits>

#include "kinome/zeroed_memory.h"

namespace kinome {

/// Array of fixed size, initialised with zeros. Pages of a large array take no memory until they
/// are written.
template <class T>
class ZeroedArray {
  static_assert(std::is_arithmetic_v<T>);

 public:
  ZeroedArray() = default;
  /// Throws std::bad_alloc.
  explicit ZeroedArray(size_t size) : memory_(bytes_of(size)), size_(size) {}

  bool empty() const { return size_ == 0; }
  size_t size() const { return size_; }
  T* data() { return static_cast<T*>(memory_.data()); }
  const T* data() const { return static_cast<const T*>(memory_.data()); }
  T& operator[](size_t i) { return static_cast<T*>(memory_.data())[i]; }
  const T& operator[](size_t i) const { return static_cast<const T*>(memory_.data())[i]; }

 private:
  static size_t bytes_of(size_t size) {
    if (size > std::numeric_limits<size_t>::max() / sizeof(T)) throw std::bad_alloc();
    return size * sizeof(T);
  }
  ZeroedMemory memory_;
  size_t size_ = 0;
};

}  // namespace kinome
