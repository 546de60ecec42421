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

class HenyeyGreenstein final : public wide::HenyeyGreensteinPhase {
 public:
  explicit HenyeyGreenstein(const Properties& props)
      : HenyeyGreensteinPhase(props.real("g", "must be greater than -1 and less than 1",
                                         [](float g) { return std::abs(g) < 1; })) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::HenyeyGreenstein, kinome::Category::kPhase, "hg",
              "The phase function of Henyey and Greenstein.", kinome::kParameters);
