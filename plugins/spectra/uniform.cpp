// A spectrum that is the same at all wavelengths: in RGB, white times its value. That holds for
// emission, too, unlike <spectrum value="1"/>, whose emission is the colour of equal energy.
//
//   <spectrum type="uniform" name="reflectance"><float name="value" value="0.3"/></spectrum>

#include "one_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"value", ParameterType::kFloat, nullptr, "value at all wavelengths; not negative", true},
    ignored_row("wavelength_min", ParameterType::kFloat, "RGB has no wavelengths"),
    ignored_row("wavelength_max", ParameterType::kFloat, "RGB has no wavelengths"),
};

class UniformSpectrum final : public OneColor {
 public:
  explicit UniformSpectrum(const Properties& props)
      : OneColor(not_negative(props, "value", Rgb(props.real("value")))) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::UniformSpectrum, kinome::Category::kTexture, "uniform",
              "White times a number.", kinome::kTable);
