#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace kinome::transport {

/// Sorts the few things of a block into any number of buckets, of which it meets a few: all but
/// making it takes time in proportion to the things, not to the buckets. One per thread.
class BucketCounts {
 public:
  explicit BucketCounts(size_t buckets) : count_(buckets) {}

  void clear() {
    for (const uint32_t bucket : used_) count_[bucket] = 0;
    used_.clear();
  }
  void add(uint32_t bucket, uint32_t things = 1) {
    if (count_[bucket] == 0) used_.push_back(bucket);
    count_[bucket] += things;
  }
  /// Those that anything was added to, in ascending order.
  std::span<const uint32_t> used() {
    std::sort(used_.begin(), used_.end());
    return used_;
  }
  /// How many were added; afterwards the caller's, say for places, as long as it adds nothing.
  uint32_t& operator[](uint32_t bucket) { return count_[bucket]; }

 private:
  std::vector<uint32_t> count_;
  std::vector<uint32_t> used_;
};

}  // namespace kinome::transport
