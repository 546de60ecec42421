#include "allocation_watch.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace kinome::test {
namespace {
std::atomic<size_t> largest{0};
}

size_t largest_allocation() {
  return largest.load();
}
void reset_largest_allocation() {
  largest = 0;
}

static void* watched_allocation(size_t size) noexcept {
  size_t seen = largest.load();
  while (size > seen && !largest.compare_exchange_weak(seen, size)) {
  }
  return std::malloc(size > 0 ? size : 1);
}

}  // namespace kinome::test

// These operators are in a separate source file. Otherwise the compiler may inline only one of a
// pair and warn of a mismatch.
void* operator new(size_t size) {
  if (void* memory = kinome::test::watched_allocation(size)) return memory;
  throw std::bad_alloc();
}
// std::stable_sort allocates its buffer with this operator. The deletes below free it, too.
void* operator new(size_t size, const std::nothrow_t&) noexcept {
  return kinome::test::watched_allocation(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
