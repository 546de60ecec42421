// Checks of wide::Double.

#include "kinome/wide/doubles.h"
#include "wide_checks.h"

namespace kinome::test {
namespace {

using wide::Double;
using wide::Float;

Pairs special_pairs() {
  std::vector<float> values = special_floats();
  for (const float x : floats_of_all_kinds(1u << 26)) values.push_back(x);
  return Pairs(values);
}

/// Compares a formula of two floats in double precision, rounded to float, with scalar code. The
/// bits must be equal.
template <class Formula>
void check_formula(Failures& failures, const char* name, const Formula& formula) {
  const Pairs pairs = special_pairs();
  const auto found = pairs.map(
      [&](Float a, Float b) { return to_float(formula(to_double(a), to_double(b))); });
  for (size_t i = 0; i < pairs.count; ++i) {
    const auto expected =
        static_cast<float>(formula(double{pairs.a[i]}, double{pairs.b[i]}));
    KINOME_CHECK(same(found[i], expected), name << " of " << pairs.a[i] << ' ' << pairs.b[i] << ": "
                                                << found[i] << ", not " << expected);
  }
}

void double_operators(Failures& failures) {
  using namespace wide::formulas;
  check_formula(failures, "sum", [](auto a, auto b) { return a + b; });
  check_formula(failures, "difference", [](auto a, auto b) { return a - b; });
  check_formula(failures, "product", [](auto a, auto b) { return a * b; });
  check_formula(failures, "quotient", [](auto a, auto b) { return a / b; });
  check_formula(failures, "minus", [](auto a, auto) { return -a; });
  check_formula(failures, "several", [](auto a, auto b) { return (a * b - b) * a + 3.0 - b / 7; });
  check_formula(failures, "sqrt", [](auto a, auto b) { return sqrt(a * a + b * b); });
  check_formula(failures, "abs", [](auto a, auto) { return abs(a); });
  check_formula(failures, "copysign", [](auto a, auto b) { return copysign(a, b); });
  check_formula(failures, "min", [](auto a, auto b) { return min(a, b); });
  check_formula(failures, "max", [](auto a, auto b) { return max(a, b); });
}

void double_comparisons(Failures& failures) {
  using namespace wide::formulas;
  using std::numbers::pi;
  check_formula(failures, "less", [](auto a, auto b) { return select(a < b, a, b * pi); });
  check_formula(failures, "at most", [](auto a, auto b) { return select(a <= b, a, b * pi); });
  check_formula(failures, "more", [](auto a, auto b) { return select(a > b, a, b * pi); });
  check_formula(failures, "at least", [](auto a, auto b) { return select(a >= b, a, b * pi); });
  check_formula(failures, "equal", [](auto a, auto b) { return select(a == b, a, b * pi); });
  check_formula(failures, "different", [](auto a, auto b) { return select(a != b, a, b * pi); });
  check_formula(failures, "finite", [](auto a, auto b) { return select(is_finite(a), a, b * pi); });
  check_formula(failures, "beyond float", [](auto a, auto b) {
    return select(a * 1e-30 < b && b * 1e300 > a, a, b * pi);
  });
  // Masks of floats select doubles of the same lanes, and masks of doubles select floats.
  const Pairs pairs = special_pairs();
  const auto found = pairs.map([](Float a, Float b) {
    const Double doubles = select(a < b, to_double(a), to_double(b) * 2.0);
    return select(to_double(a) < to_double(b), to_float(doubles), b);
  });
  for (size_t i = 0; i < pairs.count; ++i) {
    const float expected = pairs.a[i] < pairs.b[i] ? pairs.a[i] : pairs.b[i];
    KINOME_CHECK(same(found[i], expected), pairs.a[i] << ' ' << pairs.b[i]);
  }
}

void double_angles(Failures& failures) {
  const std::vector<float> angles = floats_between(-20, 20, 5000);
  // Offset that a float doesn't resolve.
  constexpr double kOffset = 1e-9;
  const auto sine_or_cosine = [](bool is_sine) {
    return [is_sine](Float x) {
      Double s, c;
      sincos(to_double(x) + kOffset, s, c);
      return to_float(is_sine ? s : c);
    };
  };
  const std::vector<float> sines = map_wide(angles, sine_or_cosine(true));
  const std::vector<float> cosines = map_wide(angles, sine_or_cosine(false));
  for (size_t i = 0; i < angles.size(); ++i) {
    const double exact = double{angles[i]} + kOffset;
    KINOME_CHECK(std::abs(sines[i] - std::sin(exact)) <= 0x1p-23, "sine of " << exact);
    KINOME_CHECK(std::abs(cosines[i] - std::cos(exact)) <= 0x1p-23, "cosine of " << exact);
  }
  const Pairs pairs(floats_between(-3, 3, 60));
  const auto found =
      pairs.map([](Float y, Float x) { return to_float(atan2(to_double(y), to_double(x))); });
  for (size_t i = 0; i < pairs.count; ++i) {
    const auto expected = std::atan2(double{pairs.a[i]}, double{pairs.b[i]});
    KINOME_CHECK(std::abs(found[i] - expected) <= 4 * 0x1p-23 * std::abs(expected),
                 "angle of " << pairs.a[i] << ' ' << pairs.b[i]);
  }
}

void double_vectors(Failures& failures) {
  using namespace wide::formulas;
  const glm::dmat3 m(.1, .2, -.3, 4, -5, 6e3, .7, 8, 9);
  const glm::dvec3 offset(1, -2e8, 3);
  const auto vector_of = [](auto a, auto b) {
    return DVecOf<decltype(a)>(a, b, a * b);
  };
  using V = glm::dvec3;
  const auto check = [&](const char* name, const auto& formula) {
    check_formula(failures, name, [&](auto a, auto b) {
      const auto v = formula(vector_of(a, b));
      return v.x + v.y * .5 + v.z * .25;
    });
  };
  check("matrix", [&](const auto& v) { return m * v; });
  check("transposed", [&](const auto& v) { return v * m; });
  check("moved", [&](const auto& v) { return v - std::remove_cvref_t<decltype(v)>(offset); });
  check("halved", [&](const auto& v) { return v / v.x; });
  check("turned round", [&](const auto& v) { return -v * v.y + v; });
  check("chosen", [&](const auto& v) { return select(v.x < v.y, v, v * v.x); });
  check_formula(failures, "dot", [&](auto a, auto b) {
    return dot(vector_of(a, b), vector_of(b, a));
  });
  check_formula(failures, "length", [&](auto a, auto b) { return length(vector_of(a, b)); });
  static_assert(std::is_same_v<DVecOf<double>, V>);
}

}  // namespace

const std::vector<WideCheck>& double_checks() {
  static const std::vector<WideCheck> checks = {{"DoubleOperators", double_operators},
                                                {"DoubleComparisons", double_comparisons},
                                                {"DoubleAngles", double_angles},
                                                {"DoubleVectors", double_vectors}};
  return checks;
}

}  // namespace kinome::test
