// Checks of wide::Int and wide::Uint.

#include "wide_checks.h"

namespace kinome::test {
namespace {

using wide::Float;
using wide::Int;
using wide::Mask;
using wide::Uint;

const std::vector<uint32_t>& special_bits() {
  static const std::vector<uint32_t> values = [] {
    std::vector<uint32_t> list = {0,          1,          2,          3,     7,         31,
                                  0x7fffffff, 0x80000000, 0x80000001, ~0u,   ~1u,       65535,
                                  65536,      0xffff0000, 0x12345678, 46341, 0x3f800000};
    for (uint32_t i = 1, x = 1; i < 40; ++i) list.push_back(x = x * 1664525u + 1013904223u);
    return list;
  }();
  return values;
}

/// Returns fn of all pairs, as bits.
template <class T, class Fn>
std::vector<uint32_t> map_pairs(const Fn& fn, std::vector<std::pair<uint32_t, uint32_t>>& pairs) {
  pairs.clear();
  for (const uint32_t a : special_bits()) {
    for (const uint32_t b : special_bits()) pairs.emplace_back(a, b);
  }
  std::vector<uint32_t> a(padded(pairs.size())), b(a.size()), result(a.size());
  for (size_t i = 0; i < pairs.size(); ++i) a[i] = pairs[i].first, b[i] = pairs[i].second;
  wide::for_lanes(pairs.size(),
                  [&](size_t i) { fn(T::load(&a[i]), T::load(&b[i])).store(&result[i]); });
  return result;
}

template <class T, class Wide, class Fn>
void check_pairs(Failures& failures, const char* name, const Wide& wide_fn, const Fn& fn) {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  const std::vector<uint32_t> results = map_pairs<T>(wide_fn, pairs);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const auto [a, b] = pairs[i];
    KINOME_CHECK(results[i] == static_cast<uint32_t>(fn(a, b)),
                 name << ' ' << a << ' ' << b << ": " << results[i]);
  }
}

#define KINOME_CHECK_BOTH(T, plain, expression)                                                \
  check_pairs<T>(                                                                              \
      failures, #T " " #expression, [](T a, [[maybe_unused]] T b) -> T { return expression; }, \
      [](uint32_t a_bits, uint32_t b_bits) -> plain {                                          \
        using namespace wide::formulas;                                                        \
        auto a = static_cast<plain>(a_bits);                                                   \
        [[maybe_unused]] const auto b = static_cast<plain>(b_bits);                            \
        return expression;                                                                     \
      })

/// Wide integers wrap around, while overflow of signed scalar integers is undefined.
void wrapping(Failures& failures) {
  check_pairs<Int>(
      failures, "a + b", [](Int a, Int b) { return a + b; },
      [](uint32_t a, uint32_t b) { return a + b; });
  check_pairs<Int>(
      failures, "a - b", [](Int a, Int b) { return a - b; },
      [](uint32_t a, uint32_t b) { return a - b; });
  check_pairs<Int>(
      failures, "a b", [](Int a, Int b) { return a * b; },
      [](uint32_t a, uint32_t b) { return a * b; });
  check_pairs<Int>(
      failures, "-a", [](Int a, Int) { return -a; }, [](uint32_t a, uint32_t) { return 0u - a; });
  check_pairs<Int>(
      failures, "|a|", [](Int a, Int) { return abs(a); },
      [](uint32_t a, uint32_t) { return a >> 31 ? 0u - a : a; });
  check_pairs<Int>(
      failures, "a += ...",
      [](Int a, Int b) { return a += b, a *= b, a -= 3, a ^= b, a |= 5, a &= b, a; },
      [](uint32_t a, uint32_t b) { return a += b, a *= b, a -= 3, a ^= b, a |= 5, a &= b, a; });
  KINOME_CHECK_BOTH(Uint, uint32_t, a + b);
  KINOME_CHECK_BOTH(Uint, uint32_t, a - b);
  KINOME_CHECK_BOTH(Uint, uint32_t, a * b);
  KINOME_CHECK_BOTH(Uint, uint32_t, (a += b, a *= b, a -= 3, a ^= b, a |= 5, a &= b, a));
}

void bits(Failures& failures) {
  KINOME_CHECK_BOTH(Int, int32_t, (a & b) | (~a ^ b));
  KINOME_CHECK_BOTH(Int, int32_t, shift_left<3>(a));
  KINOME_CHECK_BOTH(Int, int32_t, shift_left<0>(a));
  KINOME_CHECK_BOTH(Int, int32_t, shift_left<31>(a));
  KINOME_CHECK_BOTH(Int, int32_t, shift_right<3>(a));
  KINOME_CHECK_BOTH(Int, int32_t, shift_right<31>(a));
  KINOME_CHECK_BOTH(Int, int32_t, as_int(as_uint(a)));
  KINOME_CHECK_BOTH(Uint, uint32_t, (a & b) | (~a ^ b));
  KINOME_CHECK_BOTH(Uint, uint32_t, shift_left<3>(a));
  KINOME_CHECK_BOTH(Uint, uint32_t, shift_left<31>(a));
  KINOME_CHECK_BOTH(Uint, uint32_t, shift_right<3>(a));
  KINOME_CHECK_BOTH(Uint, uint32_t, shift_right<31>(a));
  KINOME_CHECK_BOTH(Uint, uint32_t, as_uint(as_int(a)));
  KINOME_CHECK_BOTH(Uint, uint32_t, as_uint(as_float(a & 0x7f7fffff)));
}

void comparisons(Failures& failures) {
  KINOME_CHECK_BOTH(Int, int32_t, select(a < b, a, b));
  KINOME_CHECK_BOTH(Int, int32_t, select(a <= b, a, b));
  KINOME_CHECK_BOTH(Int, int32_t, select(a > b, a, b));
  KINOME_CHECK_BOTH(Int, int32_t, select(a >= b, a, b));
  KINOME_CHECK_BOTH(Int, int32_t, select(a == b, a, b - b));
  KINOME_CHECK_BOTH(Int, int32_t, select(a != b, a, b - b));
  KINOME_CHECK_BOTH(Int, int32_t, select(a < b, a));
  KINOME_CHECK_BOTH(Int, int32_t, min(a, b));
  KINOME_CHECK_BOTH(Int, int32_t, max(a, b));
  KINOME_CHECK_BOTH(Int, int32_t, clamp(a, min(b, a ^ a), max(b, a ^ a)));
  KINOME_CHECK_BOTH(Uint, uint32_t, select(a < b, a, b));
  KINOME_CHECK_BOTH(Uint, uint32_t, select(a <= b, a, b));
  KINOME_CHECK_BOTH(Uint, uint32_t, select(a > b, a, b));
  KINOME_CHECK_BOTH(Uint, uint32_t, select(a >= b, a, b));
  KINOME_CHECK_BOTH(Uint, uint32_t, select(a == b, a, b - b));
  KINOME_CHECK_BOTH(Uint, uint32_t, select(a != b, a, b - b));
  KINOME_CHECK_BOTH(Uint, uint32_t, select(a < b, a));
  KINOME_CHECK_BOTH(Uint, uint32_t, min(a, b));
  KINOME_CHECK_BOTH(Uint, uint32_t, max(a, b));
  KINOME_CHECK_BOTH(Uint, uint32_t, clamp(a, shift_right<2>(b), b));
}

void conversions(Failures& failures) {
  // Double rounding would be wrong for halves between two floats and for their neighbours.
  std::vector<uint32_t> numbers = special_bits();
  for (uint32_t i = 24; i < 32; ++i) {
    for (const uint32_t low : {1u, 2u, 3u}) {
      const uint32_t half = 1u << (i - 24);
      numbers.push_back((1u << i) + low * half);
      numbers.push_back((1u << i) + low * half + 1);
      numbers.push_back((1u << i) + low * half - 1);
    }
  }
  for (const uint32_t bits : numbers) {
    std::array<float, kBlockLanes> result{};
    to_float(Uint(bits)).store(result.data());
    KINOME_CHECK(result[0] == static_cast<float>(bits), bits);
    to_float(as_int(Uint(bits))).store(result.data());
    KINOME_CHECK(result[0] == static_cast<float>(static_cast<int32_t>(bits)), bits);
    KINOME_CHECK(wide::to_float(bits) == static_cast<float>(bits), bits);
  }
}

void gathers(Failures& failures) {
  std::vector<float> floats(1000);
  std::vector<int32_t> ints(floats.size());
  std::vector<uint32_t> uints(floats.size());
  for (size_t i = 0; i < floats.size(); ++i) {
    floats[i] = std::sqrt(static_cast<float>(i));
    ints[i] = static_cast<int32_t>(i * i) - 5000;
    uints[i] = static_cast<uint32_t>(i) * 2654435761u;
  }
  std::array<int32_t, kBlockLanes> at{};
  for (uint32_t round = 0; round < 50; ++round) {
    for (size_t i = 0; i < kBlockLanes; ++i) {
      at[i] = static_cast<int32_t>((round * 379 + i * i * 71) % floats.size());
    }
    if (round == 0) at = {0, 999};
    const Int index = Int::load(at.data());
    std::array<float, kBlockLanes> f{};
    std::array<int32_t, kBlockLanes> n{};
    std::array<uint32_t, kBlockLanes> u{};
    gather(floats.data(), index).store(f.data());
    gather(ints.data(), index).store(n.data());
    gather(uints.data(), index).store(u.data());
    for (size_t i = 0; i < wide::kLanes; ++i) {
      const auto k = static_cast<size_t>(at[i]);
      KINOME_CHECK(f[i] == floats[k] && n[i] == ints[k] && u[i] == uints[k], k);
      KINOME_CHECK(wide::gather(floats.data(), at[i]) == floats[k], k);
      KINOME_CHECK(wide::gather(ints.data(), at[i]) == ints[k], k);
      KINOME_CHECK(wide::gather(uints.data(), at[i]) == uints[k], k);
    }
  }
}

}  // namespace

const std::vector<WideCheck>& integer_checks() {
  static const std::vector<WideCheck> checks = {
      {"IntegersWrapAround", wrapping}, {"IntegersBits", bits}, {"IntegersCompare", comparisons},
      {"IntegersConvert", conversions}, {"Gathers", gathers},
  };
  return checks;
}

}  // namespace kinome::test
