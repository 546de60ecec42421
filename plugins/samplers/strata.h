#pragma once

#include <algorithm>
#include <memory>

#include "permutation.h"
#include "sample_sets.h"

namespace kinome {

/// Salts that distinguish the keys of single numbers from those of pairs at the same dimension.
inline constexpr uint32_t kOneDimension = 0, kTwoDimensions = 1u << 31;

/// Parameter of samplers with optional jitter.
inline constexpr Parameter kJitter{"jitter", ParameterType::kBoolean, "true",
                                   "jitter samples in their strata; false: use the centres"};

/// A number in [0,1), or a pair of them.
template <class U>
using Real = decltype(to_unit_float(U()));
template <class U>
struct Pair {
  Real<U> x, y;
};

/// Random positions of samples within their strata.
struct Jitter {
  bool is_random;  ///< if false, each sample is at the centre of its stratum

  template <class U>
  KINOME_WIDE Real<U> one(U within, const PixelKey<U>& key) const {
    return is_random ? to_unit_float(bits(within, key)) : Real<U>(0.5f);
  }
  template <class U>
  KINOME_WIDE Pair<U> two(U within, const PixelKey<U>& key) const {
    if (!is_random) return {0.5f, 0.5f};
    // A random point of a lattice of 2^32 points. Multiplier: L'Ecuyer 1999, "Tables of linear
    // congruential generators of different sizes and good lattice structure".
    const U x = bits(within, key);
    return {to_unit_float(x), to_unit_float(x * U(747796405u))};
  }

 private:
  template <class U>
  KINOME_WIDE static U bits(U within, const PixelKey<U>& key) {
    return mix_32(within * U(0x9e3779b1u) + key.low);
  }
};

/// Returns (stratum + jitter) * size, but less than 1.
template <class U>
KINOME_WIDE Real<U> in_stratum(U stratum, Real<U> jitter, float size) {
  using namespace wide::formulas;
  return min((to_float(as_int(stratum)) + jitter) * size, Real<U>(kOneMinusEpsilon));
}

/// Set of samples, one in each cell of a grid, in random order.
struct GridSet {
  GridSet(const Grid& grid, bool jitters)
      : order(grid),
        columns(grid.columns.number(), grid.rows.number()),
        rows(grid.rows.number(), grid.columns.number()),
        size(1 / static_cast<float>(grid.count())),
        jitter{jitters} {}

  uint32_t count() const { return order.grid().count(); }

  /// Random bits that choose the order of columns, and of rows.
  template <class U>
  KINOME_WIDE static U column_bits(const PixelKey<U>& key) {
    return wide::shift_right<16>(key.low);  // the lower half chooses the order of cells
  }
  template <class U>
  KINOME_WIDE static U row_bits(const PixelKey<U>& key) {
    return key.high;
  }
  /// Returns a number for each sample, each in another one of count() strata.
  template <class U>
  KINOME_WIDE Real<U> line(U within, const PixelKey<U>& key) const {
    const PermutedCell<U> cell = order.cell(within, key);
    return in_stratum(rows.part(cell.row, cell.column, row_bits(key)), jitter.one(within, key),
                      size);
  }

  CellOrder order;
  LineOrder columns, rows;
  float size;  ///< width of a stratum, 1 / count()
  Jitter jitter;
};

/// Sampler of stratified sets. Method must have a field `jitter` and these functions, the last two
/// for uint32_t and for wide::Uint:
///   static Method of_size(uint32_t count, bool jitters);      sets of at least `count` samples
///   uint32_t count() const;                                   number of samples in a set
///   Real<U> line(U within, const PixelKey<U>& key) const;     a number
///   Pair<U> square(U within, const PixelKey<U>& key) const;   a pair
/// `within` is the index of a sample in its set, and `key` the key of the set and the dimension.
template <class Method>
class StratifyingSampler : public Sampler {
 public:
  explicit StratifyingSampler(const Properties& props)
      : StratifyingSampler(read_sample_count(props), static_cast<uint64_t>(props.integer("seed")),
                           props.boolean("jitter")) {
    warn_if_rounded(props, read_sample_count(props), sample_count_);
  }
  StratifyingSampler(uint32_t count, uint64_t seed, bool jitters)
      : method_(Method::of_size(count, jitters)), sets_(method_.count()) {
    sample_count_ = method_.count();
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return sets_.at<1>(key, keys(dimension ^ kOneDimension), [&](uint32_t within, const auto& of) {
      return method_.line(within, of[0]);
    });
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return sets_.at<1>(key, keys(dimension ^ kTwoDimensions), [&](uint32_t within, const auto& of) {
      const Pair<uint32_t> pair = method_.square(within, of[0]);
      return Vec2(pair.x, pair.y);
    });
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    sets_.for_each_vector<1>(samples, keys(dimension ^ kOneDimension),
                             [&](size_t i, wide::Uint within, const auto& of) {
                               method_.line(within, of[0]).store(out + i);
                             });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    sets_.for_each_vector<1>(samples, keys(dimension ^ kTwoDimensions),
                             [&](size_t i, wide::Uint within, const auto& of) {
                               const Pair<wide::Uint> pair = method_.square(within, of[0]);
                               pair.x.store(out.x + i);
                               pair.y.store(out.y + i);
                             });
  }

  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<StratifyingSampler>(count, seed_, method_.jitter.is_random);
  }

 private:
  static auto keys(uint32_t salt) {
    return [salt](const SampleKey& key, uint32_t set) {
      return std::array<uint64_t, 1>{hash_key(key, set, salt)};
    };
  }

  Method method_;
  SampleSets sets_;
};

}  // namespace kinome
