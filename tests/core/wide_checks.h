#pragma once

// Checks of wide numbers. They are compiled once for each instruction set, each time into a
// separate library. The test program loads the libraries that the processor can run, so they must
// not use GoogleTest.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "kinome/instruction_set.h"
#include "kinome/wide/functions.h"

namespace kinome::test {

/// The first few failed checks.
class Failures {
 public:
  void add(const char* file, int line, const std::string& what) {
    constexpr size_t kMaxMessages = 10;
    if (list_.size() >= kMaxMessages) return;
    list_.push_back(std::string(file) + ":" + std::to_string(line) + ": " + what);
  }
  const std::vector<std::string>& list() const { return list_; }

 private:
  std::vector<std::string> list_;
};

struct WideCheck {
  const char* name;
  void (*run)(Failures& failures);
};

/// Contents of the symbol kinome_wide_library that each library exports.
struct WideLibrary {
  const char* instruction_set;
  size_t lanes;
  const WideCheck* checks;
  size_t count;
};

// Groups of checks that the library's source files define.
#define KINOME_WIDE_CHECKS(group) const std::vector<WideCheck>& group##_checks()
KINOME_WIDE_CHECKS(number);
KINOME_WIDE_CHECKS(integer);
KINOME_WIDE_CHECKS(vector);
KINOME_WIDE_CHECKS(function);
KINOME_WIDE_CHECKS(double);

/// Reports `what` (a stream of values, such as a << ' ' << b) if the condition is false.
#define KINOME_CHECK(condition, what)               \
  do {                                              \
    if (!(condition)) {                             \
      std::ostringstream text;                      \
      text.precision(9);                            \
      text << #condition << ": " << what;           \
      failures.add(__FILE__, __LINE__, text.str()); \
    }                                               \
  } while (false)

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Returns true if a and b have equal bits. All NaN are equal.
inline bool same(float a, float b) {
  return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b) || (a != a && b != b);
}

/// Extreme and typical floats: zeros, the smallest and largest values, infinity, NaN and others.
inline const std::vector<float>& special_floats() {
  static const std::vector<float> values = {0.f,
                                            -0.f,
                                            1.f,
                                            -1.f,
                                            0.5f,
                                            -0.5f,
                                            1.5f,
                                            2.5f,
                                            -3.5f,
                                            0.1f,
                                            3.1415927f,
                                            1e-3f,
                                            -7e4f,
                                            1e10f,
                                            -1e20f,
                                            0x1p-149f,
                                            -0x1p-149,
                                            0x1p-130f,
                                            0x1p-126f,
                                            0x1p23f,
                                            8388609.f,
                                            0x1p-25f,
                                            0x1.fffffep-1f,
                                            0x1.fffffep127f,
                                            -0x1.fffffep127f,
                                            kInfinity,
                                            -kInfinity,
                                            kNan};
  return values;
}

/// Returns one float of each `stride` bit patterns: all magnitudes, both signs, infinite and NaN.
inline std::vector<float> floats_of_all_kinds(uint32_t stride) {
  std::vector<float> values = special_floats();
  for (uint64_t bits = 0; bits < (uint64_t(1) << 32); bits += stride) {
    values.push_back(std::bit_cast<float>(static_cast<uint32_t>(bits)));
  }
  return values;
}

/// Returns count + 1 equally spaced values from lo to hi.
inline std::vector<float> floats_between(float lo, float hi, int count) {
  std::vector<float> values;
  for (int i = 0; i <= count; ++i) {
    values.push_back(
        std::clamp(lo + (hi - lo) * static_cast<float>(i) / static_cast<float>(count), lo, hi));
  }
  return values;
}

/// Applies fn to all values, one SIMD vector at a time.
template <class Fn>
std::vector<float> map_wide(std::vector<float> values, const Fn& fn) {
  const size_t count = values.size();
  values.resize(padded(count), values.empty() ? 0.f : values.back());
  wide::for_lanes(count, [&](size_t i) { fn(wide::Float::load(&values[i])).store(&values[i]); });
  values.resize(count);
  return values;
}

/// All pairs of the values.
struct Pairs {
  explicit Pairs(const std::vector<float>& values) {
    for (const float x : values) {
      for (const float y : values) a.push_back(x), b.push_back(y);
    }
    count = a.size();
    a.resize(padded(count)), b.resize(padded(count));
  }
  template <class Fn>
  std::vector<float> map(const Fn& fn) const {
    std::vector<float> result(a.size());
    wide::for_lanes(count, [&](size_t i) {
      fn(wide::Float::load(&a[i]), wide::Float::load(&b[i])).store(&result[i]);
    });
    return result;
  }
  std::vector<float> a, b;
  size_t count;
};

}  // namespace kinome::test
