#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "kinome/zeroed_memory.h"

namespace kinome {

template <class T>
struct LargeArrayAllocator {
  using value_type = T;
  static_assert(alignof(T) <= ZeroedMemory::kMinAlignment);
  LargeArrayAllocator() = default;
  template <class U>
  LargeArrayAllocator(const LargeArrayAllocator<U>&) {}
  T* allocate(size_t count) {
    if (count > std::numeric_limits<size_t>::max() / sizeof(T)) throw std::bad_alloc();
    return static_cast<T*>(ZeroedMemory(count * sizeof(T)).detach());
  }
  void deallocate(T* memory, size_t count) { ZeroedMemory::release(memory, count * sizeof(T)); }
  /// Leaves the element uninitialised.
  template <class U>
  void construct(U* /*element*/) noexcept {
    static_assert(std::is_trivially_copyable_v<U> && std::is_trivially_destructible_v<U>);
  }
  template <class U, class... Arguments>
  void construct(U* element, Arguments&&... arguments) {
    ::new (static_cast<void*>(element)) U(std::forward<Arguments>(arguments)...);
  }
  bool operator==(const LargeArrayAllocator&) const { return true; }
};

/// Vector for large data that several threads write. resize() and the constructor don't write new
/// elements, so that the threads that assign them map their memory, in huge pages. New elements
/// have no default values: they consist of zero bytes in a new array, and of old bytes otherwise.
template <class T>
using LargeArray = std::vector<T, LargeArrayAllocator<T>>;

}  // namespace kinome
