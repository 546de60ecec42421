#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace kinome::transport {

/// Counters for sorting the items of a block into many buckets, of which only a few are used. All
/// functions except the constructor take time in proportion to the number of items, not of buckets.
/// Not thread-safe: use one per thread.
class BucketCounts {
 public:
  explicit BucketCounts(size_t buckets) : count_(buckets) {}

  void clear() {
    for (const uint32_t bucket : used_) count_[bucket] = 0;
    used_.clear();
  }
  void add(uint32_t bucket, uint32_t items = 1) {
    if (count_[bucket] == 0) used_.push_back(bucket);
    count_[bucket] += items;
  }
  /// Returns the buckets that items were added to, in ascending order.
  std::span<const uint32_t> used() {
    std::sort(used_.begin(), used_.end());
    return used_;
  }
  /// Number of items in a bucket. After its last add(), the caller may store other values here,
  /// such as positions.
  uint32_t& operator[](uint32_t bucket) { return count_[bucket]; }

 private:
  std::vector<uint32_t> count_;
  std::vector<uint32_t> used_;
};

}  // namespace kinome::transport
