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

static void* watched_allocation(size_t size) {
  size_t seen = largest.load();
  while (size > seen && !largest.compare_exchange_weak(seen, size)) {
  }
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}

}  // namespace kinome::test

// A separate source, lest the compiler see half of a pair inlined and warn of a mismatch.
void* operator new(size_t size) {
  return kinome::test::watched_allocation(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
