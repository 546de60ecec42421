#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinome/color.h"
#include "kinome/export.h"

namespace kinome {

/// Spectrum as pairs of wavelength [nm] and value. Wavelengths increase strictly. Linearly
/// interpolated between them, and 0 outside.
using Spectrum = std::vector<std::pair<double, double>>;

/// Parses "400:0.1, 500:0.5 …". Throws Error without a location.
KINOME_EXPORT Spectrum parse_spectrum(const std::string& text);
/// Parses `text`, the contents of `file`: two columns, with comments from `#` on. Throws Error with
/// its location in the file.
KINOME_EXPORT Spectrum parse_spectrum_file(const std::string& text, const std::string& file);
/// Parses two lists of equal length, separated by spaces or commas. Throws Error without a
/// location.
KINOME_EXPORT Spectrum parse_spectrum_lists(const std::string& wavelengths,
                                            const std::string& values);
/// Parses values at equidistant wavelengths from `first` to `last` [nm]. Throws Error without a
/// location.
KINOME_EXPORT Spectrum parse_regular_spectrum(double first, double last,
                                              const std::string& values);
/// Radiance of a black body [W / (m² sr nm)] at visible wavelengths, by Planck's law. `temperature`
/// is in kelvin, positive.
KINOME_EXPORT Spectrum black_body_spectrum(double temperature);

/// Converts an emission spectrum to linear Rec.709, not negative. A constant spectrum of 1 is
/// equal-energy white.
KINOME_EXPORT Rgb emission_color(const Spectrum& spectrum);
/// Converts a reflectance spectrum, viewed under D65, to linear Rec.709, not negative. A constant
/// spectrum of 1 is white.
KINOME_EXPORT Rgb reflectance_color(const Spectrum& spectrum);

}  // namespace kinome
