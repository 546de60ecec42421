// Checks of wide::Float and of masks.

#include "kinome/wide/rows.h"
#include "wide_checks.h"

namespace kinome::test {
namespace {

using wide::Float;
using wide::Int;
using wide::Mask;
using wide::Uint;

void lanes(Failures& failures) {
  std::array<float, kBlockLanes> values{};
  std::array<int32_t, kBlockLanes> numbers{};
  for (size_t i = 0; i < kBlockLanes; ++i) values[i] = static_cast<float>(i) + 0.25f;
  std::array<float, kBlockLanes + 1> copy{};
  for (size_t i = 0; i < kBlockLanes; i += wide::kLanes) {
    Float::load(&values[i]).store(&copy[i + 1]);  // at any address
  }
  for (size_t i = 0; i < kBlockLanes; ++i) KINOME_CHECK(copy[i + 1] == values[i], i);
  wide::iota().store(numbers.data());
  for (size_t i = 0; i < wide::kLanes; ++i) {
    KINOME_CHECK(numbers[i] == static_cast<int32_t>(i), numbers[i]);
  }
  Float(2.5f).store(copy.data());
  KINOME_CHECK(copy[wide::kLanes - 1] == 2.5f, copy[wide::kLanes - 1]);
  size_t called = 0;
  wide::for_lanes(0, [&](size_t) { ++called; });
  KINOME_CHECK(called == 0, called);
  for (const size_t count : {1, 15, 16, 17}) {
    std::vector<int> seen(padded(count) + kBlockLanes);
    wide::for_lanes(count, [&](size_t i) {
      for (size_t k = 0; k < wide::kLanes; ++k) ++seen[i + k];
    });
    for (size_t i = 0; i < seen.size(); ++i) {
      const int expected = i < (count + wide::kLanes - 1) / wide::kLanes * wide::kLanes ? 1 : 0;
      KINOME_CHECK(seen[i] == expected, count << ' ' << i);
      KINOME_CHECK(i < padded(count) || seen[i] == 0, count << ' ' << i);
    }
  }
}

void float_arithmetic(Failures& failures) {
  const Pairs pairs(special_floats());
  const auto check = [&](const char* name, const auto& wide_fn, const auto& fn) {
    const std::vector<float> results = pairs.map(wide_fn);
    for (size_t i = 0; i < pairs.count; ++i) {
      const float a = pairs.a[i], b = pairs.b[i];
      KINOME_CHECK(same(results[i], fn(a, b)),
                   name << ' ' << a << ' ' << b << ": " << results[i] << ", not " << fn(a, b));
    }
  };
#define KINOME_CHECK_BOTH(expression)                                    \
  check(                                                                 \
      #expression, [](Float a, Float b) -> Float { return expression; }, \
      [](float a, float b) -> float {                                    \
        using namespace wide::formulas;                                  \
        return expression;                                               \
      })
  KINOME_CHECK_BOTH(a + b);
  KINOME_CHECK_BOTH(a - b);
  KINOME_CHECK_BOTH(a * b);
  KINOME_CHECK_BOTH(a / b);
  KINOME_CHECK_BOTH((a += b, a *= b, a -= b, a /= b, a));
  KINOME_CHECK_BOTH(-a + 2.f * b - 1.f / a);
  KINOME_CHECK_BOTH(min(a, b));
  KINOME_CHECK_BOTH(max(a, b));
  KINOME_CHECK_BOTH(clamp(a, -b, b));
  KINOME_CHECK_BOTH(copysign(a, b));
  KINOME_CHECK_BOTH(lerp(a, b, b));
  KINOME_CHECK_BOTH(select(a < b, a, b));
  KINOME_CHECK_BOTH(select(a <= b, a, b));
  KINOME_CHECK_BOTH(select(a > b, a, b));
  KINOME_CHECK_BOTH(select(a >= b, a, b));
  KINOME_CHECK_BOTH(select(a == b, a, b));
  KINOME_CHECK_BOTH(select(a != b, a, b));
  KINOME_CHECK_BOTH(select(a < b, a));
  KINOME_CHECK_BOTH(select(a < b, 1.f, 0.f));
  KINOME_CHECK_BOTH(select(!(a < b), a, 0.f));
  KINOME_CHECK_BOTH(select(a > 0.f && b > 0.f, a, b));
  KINOME_CHECK_BOTH(select(a > 0.f || b > 0.f, a, b));
  KINOME_CHECK_BOTH(select((a > 0.f) & (b > 0.f), a, b));
  KINOME_CHECK_BOTH(select((a > 0.f) | (b > 0.f), a, b));
  KINOME_CHECK_BOTH(select((a > 0.f) ^ (b > 0.f), a, b));
  KINOME_CHECK_BOTH(select(select(a > 1.f, a < b, b < 1.f), a, b));
#undef KINOME_CHECK_BOTH
  check(
      "std::min", [](Float a, Float b) { return min(a, b); },
      [](float a, float b) { return std::min(a, b); });
  check(
      "std::max", [](Float a, Float b) { return max(a, b); },
      [](float a, float b) { return std::max(a, b); });
}

void float_functions(Failures& failures) {
  const std::vector<float> values = floats_of_all_kinds(10007);
  const auto check = [&](const char* name, const auto& wide_fn, const auto& fn) {
    const std::vector<float> results = map_wide(values, wide_fn);
    for (size_t i = 0; i < values.size(); ++i) {
      KINOME_CHECK(same(results[i], fn(values[i])),
                   name << ' ' << values[i] << ": " << results[i] << ", not " << fn(values[i]));
    }
  };
#define KINOME_CHECK_BOTH(expression)                           \
  check(                                                        \
      #expression, [](Float a) -> Float { return expression; }, \
      [](float a) -> float {                                    \
        using namespace wide::formulas;                         \
        return expression;                                      \
      })
  KINOME_CHECK_BOTH(abs(a));
  KINOME_CHECK_BOTH(sqr(a));
  KINOME_CHECK_BOTH(sqrt(a));
  KINOME_CHECK_BOTH(safe_sqrt(a));
  KINOME_CHECK_BOTH(floor(a));
  KINOME_CHECK_BOTH(ceil(a));
  KINOME_CHECK_BOTH(round(a));
  KINOME_CHECK_BOTH(select(is_nan(a), 1.f, a));
  KINOME_CHECK_BOTH(select(is_finite(a), a, 1.f));
  KINOME_CHECK_BOTH(as_float(as_int(a)));
  KINOME_CHECK_BOTH(as_float(as_uint(a)));
  KINOME_CHECK_BOTH(as_float(as_uint(as_int(a)) ^ 0x80000000u));
  KINOME_CHECK_BOTH(to_float(to_int(select(abs(a) < 0x1p31f, a))) + 0.f);
  KINOME_CHECK_BOTH(to_float(round_to_int(select(abs(a) < 0x1p31f, a))) + 0.f);
  KINOME_CHECK_BOTH(to_float(as_int(a)));
  KINOME_CHECK_BOTH(to_float(as_uint(a)));
#undef KINOME_CHECK_BOTH
  check(
      "std::nearbyint", [](Float a) { return round(a); },
      [](float a) { return std::nearbyint(a); });
}

/// mul_add is fused if the instruction set supports it. No other operations are fused.
void multiply_and_add(Failures& failures) {
  const Pairs pairs(floats_between(-3.f, 5.f, 200));
  const auto fused = [&](float a, float b, float c) {
#if defined(__FMA__)
    return std::fma(a, b, c);
#else
    return a * b + c;
#endif
  };
  const auto check = [&](const char* name, const auto& wide_fn, const auto& fn) {
    const std::vector<float> results = pairs.map(wide_fn);
    for (size_t i = 0; i < pairs.count; ++i) {
      const float a = pairs.a[i], b = pairs.b[i];
      KINOME_CHECK(same(results[i], fn(a, b)), name << ' ' << a << ' ' << b << ' ' << results[i]);
    }
  };
  check(
      "mul_add", [](Float a, Float b) { return mul_add(a, b, 0.3f); },
      [&](float a, float b) { return fused(a, b, 0.3f); });
  check(
      "mul_sub", [](Float a, Float b) { return mul_sub(a, b, 0.3f); },
      [&](float a, float b) { return fused(a, b, -0.3f); });
  check(
      "neg_mul_add", [](Float a, Float b) { return neg_mul_add(a, b, 0.3f); },
      [&](float a, float b) { return fused(-a, b, 0.3f); });
  // If the compiler fused one of the products, these would differ.
  const volatile float tenth = 0.1f;
  check(
      "a b - b a", [](Float a, Float b) { return a * b - b * a; },
      [](float, float) { return 0.f; });
  check(
      "a b + c", [&](Float a, Float b) { return a * b + Float(float(tenth)); },
      [&](float a, float b) {
        const volatile float product = a * b;
        return product + tenth;
      });
  for (size_t i = 0; i < pairs.count; ++i) {
    using namespace wide::formulas;
    const volatile float product = pairs.a[i] * pairs.b[i];
    KINOME_CHECK(same(mul_add(pairs.a[i], pairs.b[i], 0.3f), product + 0.3f), pairs.a[i]);
    KINOME_CHECK(same(mul_sub(pairs.a[i], pairs.b[i], 0.3f), product - 0.3f), pairs.a[i]);
    KINOME_CHECK(same(neg_mul_add(pairs.a[i], pairs.b[i], 0.3f), 0.3f - product), pairs.a[i]);
  }
}

void masks(Failures& failures) {
  using namespace wide::formulas;
  const auto bits_of = [](Mask m) {
    std::array<uint32_t, kBlockLanes> values{};
    m.store(values.data());
    uint32_t bits = 0;
    for (size_t i = 0; i < wide::kLanes; ++i) {
      if (values[i] == ~0u) bits |= 1u << i;
      if (values[i] != 0 && values[i] != ~0u) bits |= 1u << 31;
    }
    return bits;
  };
  const uint32_t full = (1u << wide::kLanes) - 1;
  for (size_t n = 0; n <= wide::kLanes; ++n) {
    const Mask m = wide::first_lanes(n);
    KINOME_CHECK(bits_of(m) == (1u << n) - 1, n);
    KINOME_CHECK(bits_of(!m) == (full & ~((1u << n) - 1)), n);
    KINOME_CHECK(count(m) == n, n);
    KINOME_CHECK(any(m) == (n > 0), n);
    KINOME_CHECK(none(m) == (n == 0), n);
    KINOME_CHECK(all(m) == (n == wide::kLanes), n);
    std::array<uint32_t, kBlockLanes> values{};
    for (size_t i = 0; i < n; ++i) values[i] = static_cast<uint32_t>(i) + 1;
    KINOME_CHECK(bits_of(Mask::load(values.data())) == (1u << n) - 1, n);
    for (size_t k = 0; k <= wide::kLanes; ++k) {
      const Mask other = !wide::first_lanes(k);
      const uint32_t a = bits_of(m), b = bits_of(other);
      KINOME_CHECK(bits_of(m & other) == (a & b), n << ' ' << k);
      KINOME_CHECK(bits_of(m | other) == (a | b), n << ' ' << k);
      KINOME_CHECK(bits_of(m ^ other) == (a ^ b), n << ' ' << k);
      Mask c = m;
      c &= other;
      KINOME_CHECK(bits_of(c) == (a & b), n << ' ' << k);
      c |= m;
      KINOME_CHECK(bits_of(c) == a, n << ' ' << k);
    }
  }
  KINOME_CHECK(all(Mask(true)) && none(Mask(false)), "broadcast");
  KINOME_CHECK(all(true) && !all(false) && any(true) && !any(false), "bool");
  KINOME_CHECK(none(false) && !none(true) && count(true) == 1 && count(false) == 0, "bool");
}

void reductions(Failures& failures) {
  std::array<float, kBlockLanes> values{}, written{};
  std::array<uint32_t, kBlockLanes> numbers{}, selected{};
  float expected = 0;
  for (size_t i = 0; i < wide::kLanes; ++i) {
    values[i] = static_cast<float>((i * 7 + 3) % 16) - 5.f;
    numbers[i] = static_cast<uint32_t>(100 + i);
    expected += values[i];
  }
  const Float x = Float::load(values.data());
  const auto [min_value, max_value] =
      std::minmax_element(values.begin(), values.begin() + wide::kLanes);
  KINOME_CHECK(sum(x) == expected, sum(x));
  KINOME_CHECK(smallest(x) == *min_value, smallest(x));
  KINOME_CHECK(largest(x) == *max_value, largest(x));
  const Mask positive = x > 0.f;
  const size_t count = store_selected(positive, x, written.data());
  KINOME_CHECK(store_selected(positive, Uint::load(numbers.data()), selected.data()) == count,
               count);
  size_t next = 0;
  for (size_t i = 0; i < wide::kLanes; ++i) {
    if (values[i] <= 0) continue;
    KINOME_CHECK(written[next] == values[i] && selected[next] == numbers[i], i);
    ++next;
  }
  KINOME_CHECK(next == count, count);
  // Nothing is written after the selected values.
  std::array<uint32_t, kBlockLanes> alone{};
  alone.fill(7);
  KINOME_CHECK(store_only_selected(positive, Uint::load(numbers.data()), alone.data()) == count,
               count);
  for (size_t i = 0; i < kBlockLanes; ++i) {
    KINOME_CHECK(alone[i] == (i < count ? selected[i] : 7u), i);
  }
}

void rows(Failures& failures) {
  std::array<float, 4 * wide::kLanes> columns{}, stored{}, loaded{};
  for (size_t i = 0; i < columns.size(); ++i) columns[i] = static_cast<float>(i);
  const float* const column = columns.data();
  store_rows(Float::load(column), Float::load(column + wide::kLanes),
             Float::load(column + 2 * wide::kLanes), Float::load(column + 3 * wide::kLanes),
             stored.data());
  Float of[4];
  load_rows(stored.data(), of[0], of[1], of[2], of[3]);
  for (size_t k = 0; k < 4; ++k) {
    of[k].store(loaded.data() + k * wide::kLanes);
    for (size_t lane = 0; lane < wide::kLanes; ++lane) {
      KINOME_CHECK(stored[4 * lane + k] == columns[k * wide::kLanes + lane], lane);
      KINOME_CHECK(loaded[k * wide::kLanes + lane] == columns[k * wide::kLanes + lane], lane);
    }
  }
  for (const size_t stride : {4, 5, 16}) {
    std::vector<float> strided(wide::kLanes * stride, -1.f);
    store_rows(of[0], of[1], of[2], of[3], strided.data(), stride);
    for (size_t i = 0; i < strided.size(); ++i) {
      const size_t lane = i / stride, k = i % stride;
      KINOME_CHECK(strided[i] == (k < 4 ? stored[4 * lane + k] : -1.f), i);
    }
  }
}

void sums_of_four(Failures& failures) {
  const std::vector<float> values = floats_of_all_kinds(10007);
  for (size_t i = 0; i + 4 * wide::kLanes <= values.size(); i += wide::kLanes) {
    Float vectors[4];
    for (size_t k = 0; k < 4; ++k) vectors[k] = Float::load(&values[i + k * wide::kLanes]);
    float sums[4];
    store_sums(vectors, sums);
    for (size_t k = 0; k < 4; ++k) KINOME_CHECK(same(sums[k], sum(vectors[k])), i << ' ' << k);
  }
}

}  // namespace

const std::vector<WideCheck>& number_checks() {
  static const std::vector<WideCheck> checks = {
      {"Lanes", lanes},
      {"FloatArithmetic", float_arithmetic},
      {"FloatFunctions", float_functions},
      {"MultiplyAndAdd", multiply_and_add},
      {"Masks", masks},
      {"Reductions", reductions},
      {"Rows", rows},
      {"SumsOfFour", sums_of_four},
  };
  return checks;
}

}  // namespace kinome::test
