#include "kinome/plugin.h"
#include "kinome/wide/phase.h"

/// The function of Henyey and Greenstein (1941). g is its mean cosine.
///
///     <phase type="hg"><float name="g" value="0.7"/></phase>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"g", ParameterType::kFloat, "0.8",
     "mean cosine of the deflection, between -1 and 1; positive values scatter forward"},
};

class HenyeyGreenstein final : public wide::DeflectionPhase<HenyeyGreenstein> {
 public:
  explicit HenyeyGreenstein(const Properties& props)
      : g_(props.real("g", "must be greater than -1 and less than 1",
                      [](float g) { return std::abs(g) < 1; })) {}

  template <class F>
  F value(const wide::Deflection<F>& at) const {
    return wide::henyey_greenstein(F(g_), at);
  }
  template <class F>
  wide::Deflection<F> draw(const F& u) const {
    return wide::sample_henyey_greenstein(F(g_), u);
  }

  std::array<HgLobe, 2> lobes() const override { return {HgLobe{g_, 1}, HgLobe{g_, 0}}; }

 private:
  float g_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::HenyeyGreenstein, kinome::Category::kPhase, "hg",
              "The phase function of Henyey and Greenstein.", kinome::kParameters);
