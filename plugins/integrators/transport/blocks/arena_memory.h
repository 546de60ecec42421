#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "kinome/columns.h"
#include "kinome/zeroed_memory.h"

namespace kinome::transport {

/// Allocator of columns. It takes them from slabs, so that the system maps the memory of a thread's
/// arenas at once. Each thread has its own slab; columns of one stage are adjacent. Slabs without
/// columns are kept for reuse, because threads allocate new columns for each pass. Thread-safe.
class ArenaMemory {
  /// True if all columns are allocated separately, so that a sanitizer detects accesses beyond a
  /// column's end.
#if defined(__SANITIZE_ADDRESS__)
  static constexpr bool kSeparate = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
  static constexpr bool kSeparate = true;
#else
  static constexpr bool kSeparate = false;
#endif
#else
  static constexpr bool kSeparate = false;
#endif

 public:
  /// Returns zeroed memory with the alignment of columns. `is_sparse`: blocks may use only the
  /// beginning, and the rest must take no memory. Throws std::bad_alloc.
  static void* take(size_t bytes, bool is_sparse) {
    if (kSeparate || bytes > (is_sparse ? kMaxSparseBytes : kMaxBytes)) {
      return take_separately(bytes);
    }
    return thread_slab().take(bytes);
  }
  /// Frees the memory that take() returned.
  static void give_back(void* memory) {
    Slab* const slab = head_of(memory).slab;
    if (slab) {
      slab->release();
    } else {
      std::free(head_of(memory).begin);
    }
  }

 private:
  static constexpr size_t kSlabBytes = ZeroedMemory::kHugePage;
  /// Maximum size of columns in slabs; longer ones are allocated separately.
  static constexpr size_t kMaxBytes = kSlabBytes / 4;
  static constexpr size_t kMaxSparseBytes = size_t{1} << 17;
  static constexpr size_t kMaxKeptSlabs = 32;

  class Slab;
  /// Header before each column. Because of its size, not all columns begin in the same cache
  /// set.
  struct alignas(kColumnAlignment) Head {
    Slab* slab;   ///< nullptr if the column is allocated separately
    void* begin;  ///< begin of a separate allocation, else nullptr
  };
  static Head& head_of(void* memory) {
    return static_cast<Head*>(memory)[-1];
  }

  static void* take_separately(size_t bytes) {
    void* const begin = std::calloc(bytes + sizeof(Head) + kColumnAlignment, 1);
    if (!begin) throw std::bad_alloc();
    void* memory = static_cast<char*>(begin) + sizeof(Head);
    size_t space = bytes + kColumnAlignment;
    std::align(kColumnAlignment, bytes, memory, space);
    head_of(memory) = {nullptr, begin};
    return memory;
  }

  /// Consecutive columns of one thread. In use while it has columns or its thread takes columns
  /// from it.
  class Slab {
   public:
    /// Returns nullptr if too little memory is left.
    void* take(size_t bytes) {
      if (users_.load(std::memory_order_acquire) == 1) used_ = 0;
      const size_t end = used_ + sizeof(Head) + bytes;
      if (end > kSlabBytes) return nullptr;
      void* const memory = static_cast<char*>(memory_.data()) + used_ + sizeof(Head);
      if (used_ < touched_) std::memset(memory, 0, bytes);
      used_ = padded_bytes(end);
      touched_ = std::max(touched_, used_);
      head_of(memory) = {this, nullptr};
      users_.fetch_add(1, std::memory_order_relaxed);
      return memory;
    }
    void release() noexcept {
      if (users_.fetch_sub(1, std::memory_order_acq_rel) == 1) pool().keep(this);
    }
    void begin_anew() noexcept { used_ = 0, users_ = 1; }

   private:
    static size_t padded_bytes(size_t bytes) {
      return (bytes + kColumnAlignment - 1) / kColumnAlignment * kColumnAlignment;
    }
    ZeroedMemory memory_{kSlabBytes};
    size_t used_ = 0;
    size_t touched_ = 0;            ///< bytes before this one may not be zero
    std::atomic<size_t> users_{1};  ///< number of columns, plus 1 for the thread
  };

  /// The slab that this thread takes columns from.
  class ThreadSlab {
   public:
    ThreadSlab() = default;
    ThreadSlab(const ThreadSlab&) = delete;
    ThreadSlab& operator=(const ThreadSlab&) = delete;
    ~ThreadSlab() {
      if (slab_) slab_->release();
    }
    void* take(size_t bytes) {
      if (slab_) {
        if (void* const memory = slab_->take(bytes)) return memory;
        std::exchange(slab_, nullptr)->release();
      }
      slab_ = pool().slab();
      return slab_->take(bytes);
    }

   private:
    Slab* slab_ = nullptr;
  };
  static ThreadSlab& thread_slab() {
    thread_local ThreadSlab thread_slab;
    return thread_slab;
  }

  static ArenaMemory& pool() {
    static ArenaMemory pool;
    return pool;
  }
  ArenaMemory() {
    kept_.reserve(kMaxKeptSlabs);
  }

  Slab* slab() {
    {
      const std::lock_guard lock(mutex_);
      if (!kept_.empty()) {
        Slab* const slab = kept_.back().release();
        kept_.pop_back();
        return slab;
      }
    }
    return new Slab;
  }
  void keep(Slab* slab) noexcept {
    std::unique_ptr<Slab> owned(slab);
    owned->begin_anew();
    const std::lock_guard lock(mutex_);
    if (kept_.size() < kMaxKeptSlabs) kept_.push_back(std::move(owned));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Slab>> kept_;
};

}  // namespace kinome::transport
