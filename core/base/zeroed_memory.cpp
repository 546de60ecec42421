#include "kinome/zeroed_memory.h"

#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

namespace kinome {
namespace {

/// Bytes of a huge page that must be used for it to be worth requesting.
constexpr size_t kMinUsedBytes = ZeroedMemory::kHugePage / 4;

/// Returns the number of bytes that are mapped for `bytes`, which are at least kMinUsedBytes.
size_t mapped_bytes(size_t bytes) {
  return (bytes + ZeroedMemory::kHugePage - 1) / ZeroedMemory::kHugePage * ZeroedMemory::kHugePage;
}

}  // namespace

ZeroedMemory::ZeroedMemory(size_t bytes) {
  constexpr size_t kMaxBytes = SIZE_MAX / 2;
  if (bytes == 0) return;
  if (bytes > kMaxBytes) throw std::bad_alloc();
  if (bytes < kMinUsedBytes) {
    const size_t padded = (bytes + kMinAlignment - 1) / kMinAlignment * kMinAlignment;
    memory_ = {std::aligned_alloc(kMinAlignment, padded), Release{bytes}};
    if (!memory_) throw std::bad_alloc();
    std::memset(memory_.get(), 0, padded);
    return;
  }
  const size_t pages = mapped_bytes(bytes);
  // Map one page more, and unmap what lies outside the aligned pages.
  void* const mapped =
      mmap(nullptr, pages + kHugePage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) throw std::bad_alloc();
  char* const begin = static_cast<char*>(mapped);
  const size_t before = (kHugePage - reinterpret_cast<uintptr_t>(begin) % kHugePage) % kHugePage;
  if (before > 0) munmap(begin, before);
  munmap(begin + before + pages, kHugePage - before);
  memory_ = {begin + before, Release{bytes}};
#if defined(MADV_HUGEPAGE)
  const size_t last = bytes - (pages - kHugePage);
  const size_t huge = last < kMinUsedBytes ? pages - kHugePage : pages;
  madvise(memory_.get(), huge, MADV_HUGEPAGE);  // fails without harm if there are no huge pages
#endif
}

void ZeroedMemory::release(void* memory, size_t bytes) {
  if (!memory) return;
  if (bytes < kMinUsedBytes) {
    std::free(memory);
  } else {
    munmap(memory, mapped_bytes(bytes));
  }
}

}  // namespace kinome
