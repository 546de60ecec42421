#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinome/color.h"
#include "kinome/export.h"

namespace kinome {

/// Wavelengths [nm], strictly increasing, and values; linear between them, zero outside.
using Spectrum = std::vector<std::pair<double, double>>;

/// "400:0.1, 500:0.5 …"; throws Error (without a place).
KINOME_EXPORT Spectrum parse_spectrum(const std::string& text);
/// Two columns; `#` begins a comment. Throws Error at its place in `file`, whose text it is.
KINOME_EXPORT Spectrum parse_spectrum_file(const std::string& text, const std::string& file);
/// Numbers, separated by spaces or commas, as many of each; throws Error (without a place).
KINOME_EXPORT Spectrum parse_spectrum_lists(const std::string& wavelengths,
                                            const std::string& values);
/// Values at equal distances from the first wavelength [nm] to the last; throws Error as above.
KINOME_EXPORT Spectrum parse_regular_spectrum(double first, double last,
                                              const std::string& values);
/// Planck's law: radiance of a black body [W / (m² sr nm)], over the visible wavelengths.
/// `temperature` in kelvin, positive.
KINOME_EXPORT Spectrum black_body_spectrum(double temperature);

/// Colour of light with this spectrum, not negative. A constant 1 is the equal-energy white.
KINOME_EXPORT Rgb emission_color(const Spectrum& spectrum);
/// Colour of a reflectance with this spectrum under daylight (D65), not negative. A constant 1 is
/// white.
KINOME_EXPORT Rgb reflectance_color(const Spectrum& spectrum);

}  // namespace kinome
