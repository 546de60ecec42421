// Windowed Gaussian, the default of films: max(0, exp(-x²/2s²) - exp(-r²/2s²)), r = 4 s.
//
//   <rfilter type="gaussian"><float name="stddev" value="0.5"/></rfilter>

#include <cmath>

#include "kinome/plugin.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/reconstruction_filter.h"

namespace kinome {
namespace {

/// Radius in standard deviations.
constexpr float kCutoff = 4;
/// Narrower filters would miss samples at a pixel's edges. A pixel without other samples would be
/// black.
constexpr float kMinStddev = 0.13f, kMaxStddev = 16;

const Parameter kTable[] = {
    {"stddev", ParameterType::kFloat, "0.5",
     "standard deviation in pixels, from 0.13 to 16; the radius is four times as large"},
};

class GaussianFilter final : public wide::FormulaFilter<GaussianFilter> {
 public:
  explicit GaussianFilter(const Properties& props)
      : stddev_(props.real("stddev", "must be between 0.13 and 16 pixels",
                           [](float s) { return s >= kMinStddev && s <= kMaxStddev; })) {
    radius_ = kCutoff * stddev_;
  }

  template <class F>
  F weight(F x) const {
    using namespace wide::formulas;
    return max(F(0.f), exp(-0.5f * sqr(x / stddev_)) - at_cutoff_);
  }

 private:
  float stddev_;
  float at_cutoff_ = std::exp(-0.5f * sqr(kCutoff));
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::GaussianFilter, kinome::Category::kReconstructionFilter, "gaussian",
              "Windowed Gaussian, smooth and without ringing; the default.", kinome::kTable);
