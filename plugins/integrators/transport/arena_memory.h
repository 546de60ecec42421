#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <vector>

#include "kinome/columns.h"

namespace kinome::transport {

/// Memory for columns. What arenas give back is kept for those to come: threads make theirs anew
/// for each pass, and small pictures would take ten times as long if the system had to find and
/// clear every page of them again. Thread-safe.
class ArenaMemory {
 public:
  /// Zeros, aligned as columns are. Throws std::bad_alloc.
  static void* take(size_t bytes) { return pool().take_zeros(bytes); }
  /// What take(bytes) gave.
  static void give_back(void* memory, size_t bytes) { pool().keep(memory, bytes); }

 private:
  /// Longer columns, of which most blocks use but the beginning, go back to the system: it clears
  /// only the pages that are used.
  static constexpr size_t kLongest = size_t{1} << 17;
  static constexpr size_t kMostKept = size_t{1} << 26;

  static ArenaMemory& pool() {
    static ArenaMemory pool;
    return pool;
  }
  ArenaMemory() = default;
  ~ArenaMemory() {
    for (const auto& [bytes, kept] : kept_) {
      for (void* const memory : kept) std::free(begin_of(memory));
    }
  }

  void* take_zeros(size_t bytes) {
    {
      const std::lock_guard lock(mutex_);
      const auto found = kept_.find(bytes);
      if (found != kept_.end() && !found->second.empty()) {
        void* const memory = found->second.back();
        found->second.pop_back();
        bytes_kept_ -= bytes;
        return std::memset(memory, 0, bytes);
      }
    }
    void* const begin = std::calloc(bytes + 2 * kColumnAlignment, 1);
    if (!begin) throw std::bad_alloc();
    // Where it begins is told in front of it.
    void* memory = static_cast<char*>(begin) + kColumnAlignment;
    size_t space = bytes + kColumnAlignment;
    std::align(kColumnAlignment, bytes, memory, space);
    std::memcpy(static_cast<char*>(memory) - sizeof begin, &begin, sizeof begin);
    return memory;
  }
  void keep(void* memory, size_t bytes) noexcept {
    if (bytes > kLongest || !is_kept(memory, bytes)) std::free(begin_of(memory));
  }
  bool is_kept(void* memory, size_t bytes) noexcept {
    const std::lock_guard lock(mutex_);
    if (bytes_kept_ + bytes > kMostKept) return false;
    try {
      kept_[bytes].push_back(memory);
    } catch (const std::bad_alloc&) {
      return false;
    }
    bytes_kept_ += bytes;
    return true;
  }
  static void* begin_of(void* memory) {
    void* begin;
    std::memcpy(&begin, static_cast<char*>(memory) - sizeof begin, sizeof begin);
    return begin;
  }

  std::mutex mutex_;
  std::map<size_t, std::vector<void*>> kept_;  ///< by their bytes
  size_t bytes_kept_ = 0;
};

}  // namespace kinome::transport
