// A spectrum given by values at equally spaced wavelengths. Converted to a colour like a <spectrum>
// with wavelengths. (Mitsuba's RGB variants read it, but can't render with it.)
//
//   <spectrum type="regular" name="radiance">
//     <float name="wavelength_min" value="400"/>
//     <float name="wavelength_max" value="700"/>
//     <string name="values" value="0.1, 0.5, 0.3"/>
//   </spectrum>

#include "spectrum_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"wavelength_min", ParameterType::kFloat, nullptr, "wavelength of the first value, in nm",
     true},
    {"wavelength_max", ParameterType::kFloat, nullptr, "wavelength of the last value, in nm", true},
    {"values", ParameterType::kString, nullptr, "two or more values", true},
};

class RegularSpectrum final : public SpectrumColor {
 public:
  explicit RegularSpectrum(const Properties& props) : SpectrumColor(read(props)) {}

 private:
  static Spectrum read(const Properties& props) {
    return read_spectrum(props, "values", [&] {
      return parse_regular_spectrum(props.real("wavelength_min"), props.real("wavelength_max"),
                                    props.string("values"));
    });
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RegularSpectrum, kinome::Category::kTexture, "regular",
              "A spectrum given by values at equally spaced wavelengths.", kinome::kTable);
