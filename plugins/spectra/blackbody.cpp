// Emission of a black body, by Planck's law. Converted to the colour that Mitsuba's spectral
// variants show, in W / (m² sr nm). (Mitsuba's RGB variants don't support it.)
//
//   <spectrum type="blackbody" name="radiance"><float name="temperature" value="5000"/></spectrum>

#include "spectrum_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"temperature", ParameterType::kFloat, nullptr, "temperature in kelvin, from 100 to 1e6", true},
    {"scale", ParameterType::kFloat, "1", "scale factor of the radiance; not negative"},
    {"wavelength_min", ParameterType::kFloat, "360",
     "shortest wavelength in nm; there is no emission below it"},
    {"wavelength_max", ParameterType::kFloat, "830",
     "longest wavelength in nm; there is no emission above it"},
};

class BlackBody final : public SpectrumColor {
 public:
  explicit BlackBody(const Properties& props) : SpectrumColor(read(props)) {}

 private:
  static Spectrum read(const Properties& props) {
    const float temperature = props.real("temperature", "must be between 100 and 1e6 kelvin",
                                         [](float t) { return t >= 100 && t <= 1e6f; });
    const float shortest = props.real("wavelength_min");
    const float longest = props.real(
        "wavelength_max", "must be greater than wavelength_min (" + format_number(shortest) + ")",
        [shortest](float w) { return shortest < w; });
    Spectrum spectrum = black_body_spectrum(temperature);
    const float scale = not_negative(props, "scale", Rgb(props.real("scale"))).x;
    for (auto& [wavelength, radiance] : spectrum) {
      radiance = shortest <= wavelength && wavelength <= longest ? radiance * scale : 0;
    }
    return spectrum;
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::BlackBody, kinome::Category::kTexture, "blackbody",
              "Emission of a black body of a given temperature.", kinome::kTable);
