// Light of a glowing body, by Planck's law. Mitsuba's RGB variants refuse to render with it; here
// it becomes the colour that its spectral variants show, in W / (m² sr nm).
//
//   <spectrum type="blackbody" name="radiance"><float name="temperature" value="5000"/></spectrum>

#include "spectrum_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"temperature", ParameterType::kFloat, nullptr, "kelvin, from 100 to 1e6", true},
    {"scale", ParameterType::kFloat, "1", "factor; not negative, as in Mitsuba 0.6"},
    {"wavelength_min", ParameterType::kFloat, "360", "nm; shorter waves are left out"},
    {"wavelength_max", ParameterType::kFloat, "830", "nm; longer waves are left out"},
};

class BlackBody final : public SpectrumColor {
 public:
  explicit BlackBody(const Properties& props) : SpectrumColor(read(props)) {}

 private:
  static Spectrum read(const Properties& props) {
    const float temperature = props.real("temperature");
    if (!(temperature >= 100 && temperature <= 1e6f)) {
      throw props.error("temperature",
                        "must lie in [100, 1e6] kelvin, got " + std::to_string(temperature));
    }
    const float shortest = props.real("wavelength_min"), longest = props.real("wavelength_max");
    if (!(shortest < longest)) {
      throw props.error("wavelength_max", "must be greater than wavelength_min (" +
                                              std::to_string(shortest) + "), got " +
                                              std::to_string(longest));
    }
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
              "Light of a glowing body.", kinome::kTable);
