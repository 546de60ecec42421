// A spectrum given by values at arbitrary wavelengths. Converted to a colour like a <spectrum> with
// wavelengths. (Mitsuba's RGB variants read it, but can't render with it.)
//
//   <spectrum type="irregular" name="radiance">
//     <string name="wavelengths" value="400, 500, 700"/>
//     <string name="values" value="0.1, 0.5, 0.3"/>
//   </spectrum>

#include "spectrum_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"wavelengths", ParameterType::kString, nullptr,
     "two or more wavelengths in nm, in increasing order", true},
    {"values", ParameterType::kString, nullptr, "values at these wavelengths", true},
};

class IrregularSpectrum final : public SpectrumColor {
 public:
  explicit IrregularSpectrum(const Properties& props) : SpectrumColor(read(props)) {}

 private:
  static Spectrum read(const Properties& props) {
    return read_spectrum(props, "values", [&] {
      return parse_spectrum_lists(props.string("wavelengths"), props.string("values"));
    });
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::IrregularSpectrum, kinome::Category::kTexture, "irregular",
              "A spectrum given by values at arbitrary wavelengths.", kinome::kTable);
