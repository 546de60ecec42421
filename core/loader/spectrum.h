#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinome/color.h"

namespace kinome {

/// Wavelengths [nm], strictly increasing, and values; linear between them, zero outside.
using Spectrum = std::vector<std::pair<double, double>>;

/// "400:0.1, 500:0.5 …"; throws Error (without a place).
Spectrum parse_spectrum(const std::string& text);
/// Two columns; `#` begins a comment. Throws Error at its place in `file`, whose text it is.
Spectrum parse_spectrum_file(const std::string& text, const std::string& file);

/// Colour of light with this spectrum, not negative. A constant 1 is the equal-energy white.
Rgb emission_color(const Spectrum& spectrum);
/// Colour of a reflectance with this spectrum under daylight (D65), not negative. A constant 1 is
/// white.
Rgb reflectance_color(const Spectrum& spectrum);

}  // namespace kinome
