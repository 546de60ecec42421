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

/// Memory for columns, out of slabs: as much as a thread's arenas take is found by the system in
/// one go. Each thread has a slab of its own to take columns from, in which those of one stage lie
/// side by side. Slabs that nobody has columns of are kept for those to come: threads make theirs
/// anew for each pass. Thread-safe.
class ArenaMemory {
  /// So that a sanitizer sees where a column ends.
#if defined(__SANITIZE_ADDRESS__)
  static constexpr bool kAlone = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
  static constexpr bool kAlone = true;
#else
  static constexpr bool kAlone = false;
#endif
#else
  static constexpr bool kAlone = false;
#endif

 public:
  /// Zeros, aligned as columns are. `is_sparse`: blocks may use but the beginning, and what they
  /// don't is to take no memory. Throws std::bad_alloc.
  static void* take(size_t bytes, bool is_sparse) {
    if (kAlone || bytes > (is_sparse ? kLongestSparse : kLongest)) return take_alone(bytes);
    return mine().take(bytes);
  }
  /// What take() gave.
  static void give_back(void* memory) {
    Slab* const slab = head_of(memory).slab;
    if (slab) {
      slab->release();
    } else {
      std::free(head_of(memory).begin);
    }
  }

 private:
  static constexpr size_t kSlab = ZeroedMemory::kHugePage;
  static constexpr size_t kLongest = kSlab / 4;
  static constexpr size_t kLongestSparse = size_t{1} << 17;
  static constexpr size_t kMostKept = 32;  ///< slabs

  class Slab;
  /// In front of each column. It also keeps columns from all beginning in the same set of a cache.
  struct alignas(kColumnAlignment) Head {
    Slab* slab;   ///< nullptr: the column is alone
    void* begin;  ///< of one that is
  };
  static Head& head_of(void* memory) {
    return static_cast<Head*>(memory)[-1];
  }

  static void* take_alone(size_t bytes) {
    void* const begin = std::calloc(bytes + sizeof(Head) + kColumnAlignment, 1);
    if (!begin) throw std::bad_alloc();
    void* memory = static_cast<char*>(begin) + sizeof(Head);
    size_t space = bytes + kColumnAlignment;
    std::align(kColumnAlignment, bytes, memory, space);
    head_of(memory) = {nullptr, begin};
    return memory;
  }

  /// Columns one after another, of one thread. In use as long as it has any, or its thread goes on.
  class Slab {
   public:
    /// nullptr where so much isn't left.
    void* take(size_t bytes) {
      if (users_.load(std::memory_order_acquire) == 1) used_ = 0;
      const size_t end = used_ + sizeof(Head) + bytes;
      if (end > kSlab) return nullptr;
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
    ZeroedMemory memory_{kSlab};
    size_t used_ = 0;
    size_t touched_ = 0;            ///< what lies before may be no zeros
    std::atomic<size_t> users_{1};  ///< columns, and the thread
  };

  /// What this thread takes columns from.
  class Mine {
   public:
    Mine() = default;
    Mine(const Mine&) = delete;
    Mine& operator=(const Mine&) = delete;
    ~Mine() {
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
  static Mine& mine() {
    thread_local Mine mine;
    return mine;
  }

  static ArenaMemory& pool() {
    static ArenaMemory pool;
    return pool;
  }
  ArenaMemory() {
    kept_.reserve(kMostKept);
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
    if (kept_.size() < kMostKept) kept_.push_back(std::move(owned));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Slab>> kept_;
};

}  // namespace kinome::transport
