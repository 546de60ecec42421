#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "pixel_keys.h"

namespace kinome {

/// Cell of a grid.
template <class U>
struct PermutedCell {
  U column, row;
};

/// Grid of cells, numbered row by row.
struct Grid {
  Grid(uint32_t column_count, uint32_t row_count) : columns(column_count), rows(row_count) {}

  uint32_t count() const { return columns.number() * rows.number(); }

  template <class U>
  KINOME_WIDE PermutedCell<U> cell(U number) const {
    const Division<U> at = columns.divide_small(number);
    return {at.remainder, at.quotient};
  }

  Modulus columns, rows;
};

/// Random permutations of 0 … count - 1, the same in each run.
class PermutationTable {
 public:
  /// Builds as many permutations as fit in `max_entries`: a power of two, at least 1.
  PermutationTable(uint32_t count, uint32_t max_entries) : stride_(std::bit_ceil(count)) {
    const uint32_t permutations =
        std::clamp(std::bit_floor(max_entries / stride_), 1u, kMaxPermutations);
    mask_ = (permutations - 1) * stride_;
    entries_.resize(size_t{permutations} * stride_);
    for (size_t first = 0; first < entries_.size(); first += stride_) {
      uint32_t* const entries = entries_.data() + first;
      std::iota(entries, entries + count, 0u);
      for (uint32_t i = count; i > 1; --i) {
        std::swap(entries[i - 1], entries[uint64_t{random_bits()} * i >> 32]);
      }
    }
  }

  /// Replaces each entry by value(entry, 32 random bits).
  template <class Value>
  void transform(const Value& value) {
    for (uint32_t& entry : entries_) entry = value(entry, random_bits());
  }

  /// Returns entry i of the permutation that the random bits above those of `count` choose.
  template <class U>
  KINOME_WIDE U at(U i, U bits) const {
    using namespace wide::formulas;
    return gather(entries_.data(), as_int((bits & U(mask_)) + i));
  }

 private:
  static constexpr uint32_t kMaxPermutations = 256;

  uint32_t random_bits() {
    return static_cast<uint32_t>(scatter(0x2545f4914f6cdd1du + ++counter_ * 0x9e3779b97f4a7c15u));
  }

  uint32_t stride_;  ///< from one permutation to the next, a power of two
  uint32_t mask_;
  uint64_t counter_ = 0;
  std::vector<uint32_t> entries_;
};

/// Random permutations of a grid's cells. Small grids use a table, read from a random entry on;
/// larger ones use a Feistel network.
class CellOrder {
 public:
  explicit CellOrder(const Grid& grid)
      : grid_(grid),
        numbers_(has_table() ? grid.count() : 1),
        table_(numbers_.number(), kMaxEntries) {
    table_.transform([&](uint32_t number, uint32_t) {
      const PermutedCell<uint32_t> cell = grid.cell(number);
      return cell.column | cell.row << 16;
    });
  }

  /// Maps a number below grid().count() to a cell, by the permutation that `key` chooses. All cells
  /// are equally likely.
  template <class U>
  KINOME_WIDE PermutedCell<U> cell(U number, const PixelKey<U>& key) const {
    if (!has_table()) return feistel(grid_.cell(number), key);
    const U entry = table_.at(numbers_.add(number, numbers_.random(key.high)), key.low);
    return {entry & U(0xffffu), wide::shift_right<16>(entry)};
  }
  const Grid& grid() const { return grid_; }

 private:
  static constexpr uint32_t kMaxEntries = 4096;  ///< 16 KiB

  bool has_table() const { return grid_.count() <= kMaxEntries; }

  /// Each round rotates the rows or columns by random amounts, which is a permutation for grids of
  /// any size.
  template <class U>
  KINOME_WIDE PermutedCell<U> feistel(PermutedCell<U> cell, const PixelKey<U>& key) const {
    const Modulus &columns = grid_.columns, &rows = grid_.rows;
    const auto shift = [](const Modulus& modulus, U line, uint32_t factor, U bits) {
      return modulus.random(mix_32(line * U(factor) + (bits + U(factor))));
    };
    cell.column = columns.add(cell.column, shift(columns, cell.row, 0x9e3779b1u, key.low));
    cell.row = rows.add(cell.row, shift(rows, cell.column, 0x85ebca77u, key.high));
    cell.column = columns.add(cell.column, shift(columns, cell.row, 0xc2b2ae3du, key.low));
    cell.row = rows.add(cell.row, shift(rows, cell.column, 0x27d4eb2fu, key.high));
    return cell;
  }

  Grid grid_;
  Modulus numbers_;
  PermutationTable table_;
};

/// Random permutations of lines, combined with a random rotation of each line's parts.
class LineOrder {
 public:
  LineOrder(uint32_t lines, uint32_t parts)
      : parts_(parts), table_(lines, std::max(kMinEntries, 16 * std::bit_ceil(lines))) {
    table_.transform([&](uint32_t line, uint32_t bits) {
      return line | static_cast<uint32_t>(uint64_t{bits} * parts >> 32) << 16;
    });
  }

  /// Maps `line` to a line, by the permutation that random bits choose.
  template <class U>
  KINOME_WIDE U line(U line, U bits) const {
    return table_.at(line, bits) & U(0xffffu);
  }
  /// Maps a part of a line to a number in [0, lines * parts).
  template <class U>
  KINOME_WIDE U part(U line, U part, U bits) const {
    const U entry = table_.at(line, bits);
    return (entry & U(0xffffu)) * U(parts_.number()) +
           parts_.add(part, wide::shift_right<16>(entry));
  }

 private:
  static constexpr uint32_t kMinEntries = 4096;

  Modulus parts_;
  PermutationTable table_;
};

}  // namespace kinome
