// Hann's window, (1 + cos(pi x / r)) / 2: smooth, and nowhere negative. Its formula is written
// once, for one position and for a vector of them.
//
//     <rfilter type="hann"> <float name="radius" value="1.5"/> </rfilter>

#include <kinome/plugin.h>
#include <kinome/wide/functions.h>
#include <kinome/wide/reconstruction_filter.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"radius", ParameterType::kFloat, "1.5", "Half its width in pixels, from 0.6 to 16."},
};

class Hann final : public wide::FormulaFilter<Hann> {
 public:
  explicit Hann(const Properties& props) {
    radius_ = props.real("radius");
    if (!(radius_ >= 0.6f && radius_ <= 16)) throw props.error("radius", "must lie in [0.6, 16]");
  }

  template <class F>
  F weight(F x) const {
    using namespace wide::formulas;
    return select(abs(x) < radius_, 0.5f + 0.5f * cos((kPi / radius_) * x), F(0.f));
  }
};

}  // namespace

KINOME_PLUGIN(Hann, Category::kReconstructionFilter, "hann", "Hann's window.", kParameters);
