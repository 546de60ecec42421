#pragma once

#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "pixel_keys.h"

namespace kinome {

/// A cell of a grid.
template <class U>
struct Cell {
  U column, row;
};

/// A grid of cells, which stand for the numbers 0 … count() - 1, row by row.
struct Grid {
  Grid(uint32_t column_count, uint32_t row_count) : columns(column_count), rows(row_count) {}

  uint32_t count() const { return columns.number() * rows.number(); }

  template <class U>
  KINOME_WIDE Cell<U> cell(U number) const {
    const Division<U> at = columns.divide(number);
    return {at.remainder, at.quotient};
  }
  template <class U>
  KINOME_WIDE U number(const Cell<U>& cell) const {
    return cell.row * U(columns.number()) + cell.column;
  }
  /// The cell to which a random permutation of all cells that `key` names moves this one. Every cell
  /// is equally likely. A Feistel network: each round rotates rows, or columns, by random amounts, and
  /// thus is a permutation for any number of them, without a search or a table.
  template <class U>
  KINOME_WIDE Cell<U> permute(Cell<U> cell, const Key<U>& key) const {
    cell.column = columns.rotate<0x9e3779b1u>(cell.column, cell.row, key.low);
    cell.row = rows.rotate<0x85ebca77u>(cell.row, cell.column, key.high);
    cell.column = columns.rotate<0xc2b2ae3du>(cell.column, cell.row, key.low);
    cell.row = rows.rotate<0x27d4eb2fu>(cell.row, cell.column, key.high);
    return cell;
  }

  Modulus columns, rows;
};

/// Random permutations of 0 … count - 1, the same ones in each run.
class PermutationTable {
 public:
  explicit PermutationTable(uint32_t count) : count_(count) {
    while (variants_ < kMostVariants && 2 * variants_ * count <= kMostEntries) variants_ *= 2;
    entries_.resize(size_t{variants_} * count);
    uint64_t counter = 0;
    for (uint32_t v = 0; v < variants_; ++v) {
      uint32_t* const entries = entries_.data() + size_t{v} * count;
      std::iota(entries, entries + count, 0u);
      for (uint32_t i = count; i > 1; --i) {
        const uint64_t bits = scatter(0x2545f4914f6cdd1du + ++counter * 0x9e3779b97f4a7c15u);
        std::swap(entries[i - 1], entries[(bits >> 32) * i >> 32]);
      }
    }
  }

  /// The place of i in the permutation that random bits choose.
  template <class U>
  KINOME_WIDE U permute(U i, U bits) const {
    using namespace wide::formulas;
    const U first = (bits & U(variants_ - 1)) * U(count_);
    return gather(entries_.data(), as_int(first + i));
  }

 private:
  static constexpr uint32_t kMostVariants = 256;
  static constexpr uint32_t kMostEntries = 4096;  ///< 16 KiB, unless 16 variants need more

  uint32_t count_;
  uint32_t variants_ = 16;
  std::vector<uint32_t> entries_;
};

}  // namespace kinome
