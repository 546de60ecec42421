#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <set>

namespace kinome::loader {

/// Estimated memory of the objects that are being made.
class MemoryInUse {
 public:
  /// Limit of the memory of all objects but the largest [bytes].
  static constexpr uint64_t kMaxOtherBytes = uint64_t{1} << 28;

  /// True if one more object may be begun. An object of any size may be begun alone.
  bool admits(uint64_t bytes) const {
    if (begun_.empty()) return true;
    const uint64_t sum = std::accumulate(begun_.begin(), begun_.end(), bytes);
    return sum - std::max(bytes, *begun_.rbegin()) <= kMaxOtherBytes;
  }
  void begin(uint64_t bytes) { begun_.insert(bytes); }
  /// Ends an object that was begun with this number of bytes.
  void end(uint64_t bytes) { begun_.erase(begun_.find(bytes)); }

 private:
  std::multiset<uint64_t> begun_;
};

}  // namespace kinome::loader
