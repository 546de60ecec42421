// Checks of the functions of wide numbers: errors in ulps, and special values.

#include "wide_checks.h"

#include "kinome/wide/near_zero.h"

namespace kinome::test {
namespace {

using wide::Float;

constexpr uint32_t kStride = 5003;  // for floats_of_all_kinds(): 860,000 values

/// Returns one unit in the last place of a float result.
double ulp_of(double exact) {
  const float magnitude = std::min(static_cast<float>(std::abs(exact)), 0x1.fffffcp127f);
  return std::nextafter(magnitude, kInfinity) - static_cast<double>(magnitude);
}

/// Returns true if `found` differs from `exact` by at most `bound` ulps. Values beyond the range of
/// floats must be infinite.
bool agrees(float found, double exact, double bound) {
  if (exact != exact) return found != found;
  if (std::isinf(exact)) return static_cast<double>(found) == exact;
  if (std::isinf(found)) {
    return std::abs(exact) > 0x1.fffffep127 * (1 - bound * 0x1p-24) && (found > 0) == (exact > 0);
  }
  return std::abs(found - exact) <= bound * ulp_of(exact);
}

template <class Wide, class Exact>
void check_ulp(Failures& failures, const char* name, double bound,
               const std::vector<float>& arguments, const Wide& wide_fn, const Exact& exact) {
  const std::vector<float> found = map_wide(arguments, wide_fn);
  for (size_t i = 0; i < arguments.size(); ++i) {
    const double expected = exact(static_cast<double>(arguments[i]));
    KINOME_CHECK(agrees(found[i], expected, bound),
                 name << ' ' << arguments[i] << ": " << found[i] << ", not " << expected);
  }
}

std::vector<float> all_and_between(float lo, float hi) {
  std::vector<float> values = floats_of_all_kinds(kStride);
  const std::vector<float> more = floats_between(lo, hi, 300000);
  values.insert(values.end(), more.begin(), more.end());
  return values;
}

void exponential(Failures& failures) {
  const auto exact = [](double x) { return std::exp(x); };
  const auto fn = [](Float x) { return exp(x); };
  check_ulp(failures, "exp", 1.1, all_and_between(-105.f, 90.f), fn, exact);
  check_ulp(failures, "exp", 1.1, floats_between(-1.f, 1.f, 300000), fn, exact);
}

void logarithm(Failures& failures) {
  const auto exact = [](double x) { return std::log(x); };
  const auto fn = [](Float x) { return log(x); };
  check_ulp(failures, "log", 1, all_and_between(0.4f, 2.5f), fn, exact);
  check_ulp(failures, "log", 1, floats_between(0.999f, 1.001f, 100000), fn, exact);
}

void near_zero(Failures& failures) {
  std::vector<float> arguments = all_and_between(-1.f, 2.f);
  const std::vector<float> small = floats_between(-1e-3f, 1e-3f, 100000);
  arguments.insert(arguments.end(), small.begin(), small.end());
  check_ulp(
      failures, "log1p", 4, arguments, [](Float x) { return log1p(x); },
      [](double x) { return std::log1p(x); });
  std::erase_if(arguments, [](float x) { return x > 80; });
  check_ulp(
      failures, "expm1", 4, arguments, [](Float x) { return expm1(x); },
      [](double x) { return std::expm1(x); });
}

void error_function(Failures& failures) {
  check_ulp(
      failures, "erf", 1.5, all_and_between(-5.f, 5.f), [](Float x) { return erf(x); },
      [](double x) { return std::erf(x); });
}

double exact_inverse_erf(double y) {
  if (!(std::abs(y) < 1)) return std::abs(y) == 1 ? y * HUGE_VAL : kNan;
  if (y == 0) return y;
  const double target = std::abs(y);
  double x = wide::inverse_erf(static_cast<float>(target));
  for (int i = 0; i < 3; ++i) {
    const double error = target < 0.5 ? std::erf(x) - target : (1 - target) - std::erfc(x);
    x -= error / (2 * std::numbers::inv_sqrtpi * std::exp(-x * x));
  }
  return std::copysign(x, y);
}
void inverse_error_function(Failures& failures) {
  std::vector<float> arguments = all_and_between(-1.f, 1.f);
  for (float y = 1, i = 0; i < 1000; ++i) arguments.push_back(y = std::nextafter(y, 0.f));
  check_ulp(
      failures, "inverse_erf", 4, arguments, [](Float y) { return inverse_erf(y); },
      exact_inverse_erf);
  for (const float y : arguments) {
    const float x = wide::inverse_erf(y);
    KINOME_CHECK(agrees(x, exact_inverse_erf(y), 4), y << ": " << x);
  }
}

void sine_and_cosine(Failures& failures) {
  constexpr double kBound = 0x1p-23;
  std::vector<float> arguments = floats_between(-8000.f, 8000.f, 500000);
  for (const float x : floats_of_all_kinds(kStride)) {
    if (!(std::abs(x) > 8000.f)) arguments.push_back(x);
  }
  // Arguments around the ends of quadrants.
  for (int i = -5000; i <= 5000; ++i) {
    const auto x = static_cast<float>(i * (std::numbers::pi / 4));
    arguments.insert(arguments.end(), {x, std::nextafter(x, 1e9f), std::nextafter(x, -1e9f)});
  }
  const auto check = [&](const char* name, const auto& wide_fn, const auto& exact) {
    const std::vector<float> found = map_wide(arguments, wide_fn);
    for (size_t i = 0; i < arguments.size(); ++i) {
      const double expected = exact(static_cast<double>(arguments[i]));
      KINOME_CHECK(std::abs(found[i] - expected) <= kBound ||
                       (arguments[i] != arguments[i] && found[i] != found[i]),
                   name << ' ' << arguments[i] << ": " << found[i] << ", not " << expected);
    }
  };
  const auto sine = [](double x) { return std::sin(x); };
  const auto cosine = [](double x) { return std::cos(x); };
  check(
      "sin", [](Float x) { return sin(x); }, sine);
  check(
      "cos", [](Float x) { return cos(x); }, cosine);
  const auto both = [](Float x, bool is_sine) {
    Float s, c;
    sincos(x, s, c);
    return is_sine ? s : c;
  };
  check(
      "sincos", [&](Float x) { return both(x, true); }, sine);
  check(
      "sincos", [&](Float x) { return both(x, false); }, cosine);
  // Near 0, sines have a small relative error.
  std::vector<float> small;
  for (const float x : floats_of_all_kinds(kStride)) {
    if (std::abs(x) < 0.5f) small.push_back(x);
  }
  check_ulp(
      failures, "small sin", 1, small, [](Float x) { return sin(x); }, sine);
}

void arctangent(Failures& failures) {
  constexpr double kBound = 2.5;
  std::vector<float> values = special_floats();
  for (const float x : floats_of_all_kinds(8'000'011)) values.push_back(x);
  for (int i = 0; i < 400; ++i) values.push_back(std::ldexp(1 + 0.37f * (i % 3), i / 10 - 20));
  const Pairs pairs(values);
  const std::vector<float> found = pairs.map([](Float y, Float x) { return atan2(y, x); });
  for (size_t i = 0; i < pairs.count; ++i) {
    const float y = pairs.a[i], x = pairs.b[i];
    const double expected = std::isinf(x) && std::isinf(y)
                                ? kNan
                                : std::atan2(static_cast<double>(y), static_cast<double>(x));
    KINOME_CHECK(agrees(found[i], expected, kBound) &&
                     (expected != expected || std::signbit(found[i]) == std::signbit(expected)),
                 "atan2 " << y << ' ' << x << ": " << found[i] << ", not " << expected);
  }
  for (const float x : {1.f, -1.f, 0x1p-100f, 1e30f, -1e-3f}) {
    check_ulp(
        failures, "atan2", kBound, all_and_between(-5.f * x, 5.f * x),
        [&](Float y) { return select(abs(y) < HUGE_VALF, atan2(y, Float(x)), Float(kNan)); },
        [&](double y) { return std::abs(y) < HUGE_VAL ? std::atan2(y, x) : kNan; });
  }
}

void arcsine(Failures& failures) {
  check_ulp(
      failures, "asin", 3, all_and_between(-1.f, 1.f), [](Float x) { return asin(x); },
      [](double x) { return std::asin(x); });
  check_ulp(
      failures, "acos", 3, all_and_between(-1.f, 1.f), [](Float x) { return acos(x); },
      [](double x) { return std::acos(x); });
}

void power(Failures& failures) {
  constexpr double kBound = 3;
  const auto exact = [](double x, double y) {
    return x < 0 && y != 0 ? kNan : std::pow(x == 0 ? 0. : x, y);
  };
  std::vector<float> values = special_floats();
  for (const float x : floats_of_all_kinds(6'000'101)) values.push_back(x);
  for (int i = -300; i < 300; ++i) values.push_back(std::exp(static_cast<float>(i) / 60));
  const Pairs pairs(values);
  const std::vector<float> found = pairs.map([](Float x, Float y) { return pow(x, y); });
  for (size_t i = 0; i < pairs.count; ++i) {
    const double expected = exact(pairs.a[i], pairs.b[i]);
    KINOME_CHECK(agrees(found[i], expected, kBound), "pow " << pairs.a[i] << ' ' << pairs.b[i]
                                                            << ": " << found[i] << ", not "
                                                            << expected);
  }
  // Numbers of all exponents whose powers are in the range of floats.
  for (const float y :
       {1.f, 2.f, 5.f, 0.5f, 2.4f, 1 / 2.4f, -1.f, -3.f, 10.f, 100.f, 1000.f, 1e5f, 1e7f}) {
    const auto lo = static_cast<float>(std::pow(1e-44, 1. / std::abs(y)));
    const auto hi = static_cast<float>(std::min(3e38, std::pow(3e38, 1. / std::abs(y))));
    std::vector<float> arguments;
    for (int i = 0; i <= 100000; ++i) {
      const double t = i / 100000.;
      arguments.push_back(static_cast<float>(std::exp((1 - t) * std::log(lo) + t * std::log(hi))));
    }
    check_ulp(
        failures, "pow", kBound, arguments, [&](Float x) { return pow(x, Float(y)); },
        [&](double x) { return std::pow(x, static_cast<double>(y)); });
  }
}

/// The scalar versions must have the bits of the standard library.
void plain_numbers(Failures& failures) {
  using namespace wide::formulas;
  for (const float x : floats_of_all_kinds(100'003)) {
    float s = 0, c = 0;
    sincos(x, s, c);
    KINOME_CHECK(same(exp(x), std::exp(x)) && same(log(x), std::log(x)), x);
    KINOME_CHECK(same(sin(x), std::sin(x)) && same(cos(x), std::cos(x)), x);
    KINOME_CHECK(same(s, std::sin(x)) && same(c, std::cos(x)), x);
    KINOME_CHECK(same(erf(x), std::erf(x)) && same(atan2(x, 2.f), std::atan2(x, 2.f)), x);
    KINOME_CHECK(same(asin(x), std::asin(x)) && same(acos(x), std::acos(x)), x);
    KINOME_CHECK(same(pow(x, 2.5f), std::pow(x, 2.5f)), x);
    const float horner = (3.f * x + 2.f) * x + 1.f;
    KINOME_CHECK(same(polynomial(x, 3.f, 2.f, 1.f), horner), x);
  }
  KINOME_CHECK(map_wide({2.f}, [](Float x) { return polynomial(x, 3.f, 2.f, 1.f); })[0] == 17.f,
               "polynomial");
}

}  // namespace

const std::vector<WideCheck>& function_checks() {
  static const std::vector<WideCheck> checks = {
      {"Exp", exponential},
      {"Log", logarithm},
      {"NearZero", near_zero},
      {"Erf", error_function},
      {"InverseErf", inverse_error_function},
      {"SinCos", sine_and_cosine},
      {"Atan2", arctangent},
      {"AsinAcos", arcsine},
      {"Pow", power},
      {"PlainNumbers", plain_numbers},
  };
  return checks;
}

}  // namespace kinome::test
