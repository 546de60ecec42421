// Mitchell and Netravali's cubics: sharp, with a little ringing. By default a compromise between
// blur and ringing. Has negative lobes.
//
//   <rfilter type="mitchell"><float name="B" value="0.33"/><float name="C" value="0.33"/></rfilter>

#include "cubic.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

/// Bounds of B and C, far beyond practical values. The filter's integral is 1 for any B and C.
constexpr float kMinParameter = -1, kMaxParameter = 2;

const Parameter kTable[] = {
    {"B", ParameterType::kFloat, "0.33333333", "amount of blur, from -1 to 2"},
    {"C", ParameterType::kFloat, "0.33333333", "amount of ringing, from -1 to 2"},
};

class MitchellFilter final : public CubicFilter {
 public:
  explicit MitchellFilter(const Properties& props)
      : CubicFilter(read(props, "B"), read(props, "C")) {}

 private:
  static float read(const Properties& props, const char* name) {
    return props.real(name, "must be between -1 and 2",
                      [](float v) { return v >= kMinParameter && v <= kMaxParameter; });
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::MitchellFilter, kinome::Category::kReconstructionFilter, "mitchell",
              "Mitchell and Netravali's cubics: sharp, with a little ringing.", kinome::kTable);
