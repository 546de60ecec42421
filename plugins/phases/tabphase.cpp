#include <charconv>
#include <cstring>
#include <vector>

#include "kinome/plugin.h"
#include "kinome/wide/phase.h"
#include "lobes.h"

/// A table of values, linear between equidistant cosines of the deflection from -1 (backward) to 1
/// (forward). It is normalised.
///
///     <phase type="tabphase"><string name="values" value="0.5, 1, 4"/></phase>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"values", ParameterType::kString, nullptr,
     "two or more nonnegative numbers: the first for light that returns, the last for "
     "light that goes straight on",
     true},
};

std::vector<double> parse_values(const Properties& props) {
  const std::string text = props.string("values");
  std::vector<double> values;
  double sum = 0;
  for (const char *at = text.data(), *const end = at + text.size(); at != end;) {
    if (std::strchr(", \t\r\n", *at)) {
      ++at;
      continue;
    }
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    const bool is_number = error == std::errc() && (next == end || std::strchr(", \t\r\n", *next));
    if (!is_number || !std::isfinite(value) || value < 0) {
      const std::string word(at, std::strcspn(at, ", \t\r\n"));
      throw props.error("values", "must be nonnegative numbers, got '" + word + "'");
    }
    values.push_back(value);
    sum += value;
    at = next;
  }
  if (values.size() < 2) {
    throw props.error("values",
                      "must be at least two numbers, got " + std::to_string(values.size()));
  }
  if (!(sum > 0) || !std::isfinite(sum)) throw props.error("values", "must have a positive sum");
  return values;
}

class TabulatedPhase final : public wide::DeflectionPhase<TabulatedPhase> {
 public:
  explicit TabulatedPhase(const Properties& props) {
    const std::vector<double> values = parse_values(props);
    const size_t last = values.size() - 1;
    intervals_ = static_cast<float>(last);
    double total = 0;
    for (size_t i = 0; i < last; ++i) total += (values[i] + values[i + 1]) / 2;
    // Values per solid angle: total is the integral in units of the spacing 2 / last.
    const double factor = static_cast<double>(last) / (4 * std::numbers::pi * total);
    double sum = 0;
    for (size_t i = 0; i <= last; ++i) {
      values_.push_back(static_cast<float>(values[i] * factor));
      shares_.push_back(static_cast<float>(sum / total));
      if (i < last) sum += (values[i] + values[i + 1]) / 2;
    }
    shares_[last] = kInfinity;  // never below a random number
    lobes_ = find_lobes(values, total);
  }

  template <class F>
  F value(const wide::Deflection<F>& at) const {
    using namespace wide::formulas;
    const F x = at.plus * (0.5f * intervals_);
    const auto last = static_cast<int32_t>(values_.size()) - 2;
    // The index is valid even if x is NaN.
    const auto i = clamp(to_int(x), wide::IntOf<F>(0), wide::IntOf<F>(last));
    const F a = gather(values_.data(), i), b = gather(values_.data() + 1, i);
    return max(a + (b - a) * (x - to_float(i)), F(0.f));
  }

  template <class F>
  wide::Deflection<F> draw(const F& u) const {
    using namespace wide::formulas;
    using plain::select, std::max, std::min, std::sqrt;
    const auto count = static_cast<int32_t>(values_.size());
    // Binary search for the last share that isn't above u. shares_[i] <= u always holds.
    wide::IntOf<F> i(0);
    int32_t step = 1;
    while (2 * step < count) step *= 2;
    for (; step > 0; step /= 2) {
      const wide::IntOf<F> next = clamp(i + step, wide::IntOf<F>(0), wide::IntOf<F>(count - 1));
      i = select(gather(shares_.data(), next) <= u, next, i);
    }
    const F a = gather(values_.data(), i), b = gather(values_.data() + 1, i);
    // The integral of a + (b - a) s over s from 0 to t is `area`.
    const F area = (u - gather(shares_.data(), i)) * (intervals_ * 0.25f * kInvPi);
    const F root = sqrt(max(a * a + 2.f * (b - a) * area, F(0.f)));
    const F t = min(select(a + root > 0.f, 2.f * area / (a + root), F(0.f)), F(1.f));
    const F x = to_float(i) + t, unit = 2 / intervals_;
    return {(intervals_ - x) * unit, x * unit};
  }

  std::array<HgLobe, 2> lobes() const override { return lobes_; }

 private:
  static std::array<HgLobe, 2> find_lobes(const std::vector<double>& values, double total) {
    const double step = 2.0 / static_cast<double>(values.size() - 1);
    double first = 0, second = 0;
    for (size_t i = 0; i + 1 < values.size(); ++i) {
      // Moments of the interval's line over c = begin + step s.
      const double a = values[i], b = values[i + 1], begin = -1 + static_cast<double>(i) * step;
      const double m0 = (a + b) / 2, m1 = a / 6 + b / 3, m2 = a / 12 + b / 4;
      const double squares = begin * begin * m0 + 2 * begin * step * m1 + step * step * m2;
      first += begin * m0 + step * m1;
      second += (3 * squares - m0) / 2;
    }
    return lobes_of_moments(static_cast<float>(first / total), static_cast<float>(second / total));
  }

  float intervals_ = 1;
  std::vector<float> values_;  ///< [1/sr]
  std::vector<float> shares_;  ///< of the light below each cosine
  std::array<HgLobe, 2> lobes_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::TabulatedPhase, kinome::Category::kPhase, "tabphase",
              "A table of values over the cosine of the deflection.", kinome::kParameters);
