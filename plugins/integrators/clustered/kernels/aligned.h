#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "kinome/columns.h"

namespace kinome {

/// Allocator for vectors that are columns (columns.h).
template <class T>
struct ColumnAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{kColumnAlignment};
  ColumnAllocator() = default;
  template <class U>
  ColumnAllocator(const ColumnAllocator<U>&) {}
  T* allocate(size_t count) {
    return static_cast<T*>(::operator new(padded(count) * sizeof(T), kAlignment));
  }
  void deallocate(T* memory, size_t) { ::operator delete(memory, kAlignment); }
  bool operator==(const ColumnAllocator&) const { return true; }
};

/// One column.
template <class T>
using Column = std::vector<T, ColumnAllocator<T>>;

}  // namespace kinome
