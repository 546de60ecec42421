#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "kinome/wide/distribution.h"

namespace kinome {

/// Searches a table for up to `kMaxCount` values at once, as wide::find_cell does for one vector.
/// Each round halves the ranges of all unfinished values, and removes the finished ones. This is
/// faster if a few values need many steps, as on a map with a sun: a single vector takes as many
/// steps as its slowest lane, and waits for memory at each.
template <size_t kMaxCount>
class CellSearch {
 public:
  /// Adds values i, i + 1, …, to be searched among `cells`. i = 0 begins a new search.
  KINOME_WIDE void add(size_t i, const wide::CellRange& cells, wide::Float u) {
    using namespace wide;
    if (i == 0) left_ = 0;
    cells.first.store(found_.data() + i);
    const Mask searched = cells.length > 0;
    keep(searched, as_uint(iota()) + static_cast<uint32_t>(i), cells, u);
  }
  /// Runs the search. Afterwards, found() has the index of each value in the table.
  void run(const float* cdf) {
    using namespace wide;
    while (left_ > 0) {
      const size_t count = std::exchange(left_, 0);
      for_lanes(count, [&](size_t i) {
        const Mask valid = first_lanes(count - i);
        const Uint number = Uint::load(number_.data() + i);
        const Float u = Float::load(u_.data() + i);
        CellRange cells{select(valid, Int::load(first_.data() + i)),
                        select(valid, Int::load(length_.data() + i))};
        cells.halve(cdf, u);
        const Mask goes_on = cells.length > 0;
        uint32_t numbers[kLanes], places[kLanes];
        const size_t done = store_selected(valid & !goes_on, number, numbers);
        store_selected(valid & !goes_on, as_uint(cells.first), places);
        for (size_t k = 0; k < done; ++k) found_[numbers[k]] = places[k];
        keep(goes_on, number, cells, u);
      });
    }
  }
  const uint32_t* found() const { return found_.data(); }

 private:
  KINOME_WIDE void keep(wide::Mask which, wide::Uint number, const wide::CellRange& cells,
                        wide::Float u) {
    store_selected(which, number, number_.data() + left_);
    store_selected(which, as_uint(cells.first), first_.data() + left_);
    store_selected(which, as_uint(cells.length), length_.data() + left_);
    left_ += store_selected(which, u, u_.data() + left_);
  }

  template <class T>
  using Column = std::array<T, kMaxCount + kBlockLanes>;
  alignas(kColumnAlignment) Column<uint32_t> found_;
  // Unfinished values:
  size_t left_ = 0;
  alignas(kColumnAlignment) Column<uint32_t> number_, first_, length_;
  alignas(kColumnAlignment) Column<float> u_;
};

}  // namespace kinome
