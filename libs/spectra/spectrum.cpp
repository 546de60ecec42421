#include "kinome/spectrum.h"

#include <algorithm>
#include <cmath>

#include "base/numbers.h"
#include "kinome/error.h"
#include "spectra/cie_tables.h"

namespace kinome {
namespace {

using DVec3 = glm::dvec3;

/// Interpolates linearly in a table that begins at kFirstWavelength, with rows every `step` nm.
template <class Table>
auto interpolated(const Table& table, int step, double wavelength) {
  const double position = (wavelength - kFirstWavelength) / step;
  const auto i = std::min(static_cast<size_t>(position), table.size() - 2);
  const double t = position - static_cast<double>(i);
  return table[i] * (1 - t) + table[i + 1] * t;
}

double daylight(double wavelength) {
  return interpolated(kDaylight, kDaylightStep, wavelength);
}

DVec3 observer(double wavelength) {
  return interpolated(kObserver, kObserverStep, wavelength);
}

double value_at(const Spectrum& spectrum, double wavelength) {
  const auto next = std::lower_bound(spectrum.begin(), spectrum.end(), wavelength,
                                     [](const auto& entry, double w) { return entry.first < w; });
  if (next == spectrum.end()) return 0;
  if (next == spectrum.begin()) return next->first == wavelength ? next->second : 0;
  const auto& [w0, v0] = *(next - 1);
  const auto& [w1, v1] = *next;
  return glm::mix(v0, v1, (wavelength - w0) / (w1 - w0));
}

Rgb xyz_to_rgb(const DVec3& c) {
  return Rgb(3.240479 * c.x - 1.537150 * c.y - 0.498535 * c.z,
             -0.969256 * c.x + 1.875991 * c.y + 0.041556 * c.z,
             0.055648 * c.x - 0.204043 * c.y + 1.057311 * c.z);
}

/// Returns the Rec.709 colour of a spectrum, scaled so that a constant spectrum of 1 has the XYZ
/// coordinates `white`. Saturated colours are out of gamut; as in Mitsuba 3, negative channels are
/// clamped to 0.
template <class Illuminant>
Rgb color(const Spectrum& spectrum, const DVec3& white, const Illuminant& illuminant) {
  DVec3 sum(0), whole(0);
  for (int w = kFirstWavelength; w <= kLastWavelength; ++w) {
    const DVec3 weight = observer(w) * illuminant(w);
    sum += weight * value_at(spectrum, w);
    whole += weight;
  }
  return glm::max(xyz_to_rgb(white * sum / whole), Rgb(0.f));
}

void append(Spectrum& spectrum, std::string_view wavelength, std::string_view value) {
  const auto w = parse_real(wavelength);
  const auto v = parse_real(value);
  if (!w || !v) {
    throw Error("'" + std::string(wavelength) + ":" + std::string(value) +
                "' is not a wavelength and a value");
  }
  if (!spectrum.empty() && *w <= spectrum.back().first) {
    throw Error("wavelengths must increase, but " + std::string(wavelength) + " doesn't");
  }
  spectrum.emplace_back(*w, *v);
}

constexpr size_t kMinWavelengths = 2;
constexpr const char* kTooFew = "a spectrum needs at least two wavelengths";

}  // namespace

Spectrum parse_spectrum(const std::string& text) {
  Spectrum spectrum;
  for (const std::string_view part : split_list(text)) {
    const size_t colon = std::min(part.find(':'), part.size());
    append(spectrum, part.substr(0, colon), part.substr(std::min(colon + 1, part.size())));
  }
  if (spectrum.size() < kMinWavelengths) throw Error(kTooFew);
  return spectrum;
}

Spectrum parse_spectrum_file(const std::string& text, const std::string& file) {
  Spectrum spectrum;
  Location where{file, 1, 1};
  for (size_t begin = 0; begin < text.size(); ++where.line) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    const auto columns = split_list(line.substr(0, line.find('#')));
    if (columns.empty()) continue;
    where.column = 1 + static_cast<int>(columns[0].data() - line.data());
    if (columns.size() != 2) {
      throw Error(where, "a line of a spectrum file has a wavelength and a value, not '" +
                             std::string(trim(line)).substr(0, 40) + "'");
    }
    try {
      append(spectrum, columns[0], columns[1]);
    } catch (const Error& error) {
      throw Error(where, error.message());
    }
  }
  if (spectrum.size() < kMinWavelengths) throw Error(Location{file}, kTooFew);
  return spectrum;
}

Spectrum parse_spectrum_lists(const std::string& wavelengths, const std::string& values) {
  const auto columns = split_list(wavelengths), rows = split_list(values);
  if (columns.size() != rows.size()) {
    throw Error("a spectrum needs as many values as wavelengths, got " +
                std::to_string(rows.size()) + " and " + std::to_string(columns.size()));
  }
  Spectrum spectrum;
  for (size_t i = 0; i < columns.size(); ++i) append(spectrum, columns[i], rows[i]);
  if (spectrum.size() < kMinWavelengths) throw Error(kTooFew);
  return spectrum;
}

Spectrum parse_regular_spectrum(double first, double last, const std::string& values) {
  if (!(first < last)) throw Error("wavelengths must increase, but the last isn't above the first");
  const auto numbers = parse_reals(values);
  if (!numbers) throw Error("'" + values.substr(0, 40) + "' is not a list of numbers");
  if (numbers->size() < kMinWavelengths) throw Error(kTooFew);
  Spectrum spectrum;
  const auto steps = static_cast<double>(numbers->size() - 1);
  for (size_t i = 0; i < numbers->size(); ++i) {
    spectrum.emplace_back(glm::mix(first, last, static_cast<double>(i) / steps), (*numbers)[i]);
  }
  return spectrum;
}

Spectrum black_body_spectrum(double temperature) {
  constexpr double kPlanck = 6.62607015e-34, kLightSpeed = 299792458, kBoltzmann = 1.380649e-23;
  constexpr double kMetre = 1e-9;  // in nm
  Spectrum spectrum;
  for (int w = kFirstWavelength; w <= kLastWavelength; ++w) {
    const double length = w * kMetre;
    const double energy = kPlanck * kLightSpeed / (length * kBoltzmann * temperature);
    const double radiance =
        2 * kPlanck * kLightSpeed * kLightSpeed / (std::pow(length, 5) * std::expm1(energy));
    spectrum.emplace_back(w, radiance * kMetre);
  }
  return spectrum;
}

Rgb emission_color(const Spectrum& spectrum) {
  return color(spectrum, DVec3(1), [](double) { return 1.0; });
}

Rgb reflectance_color(const Spectrum& spectrum) {
  return color(spectrum, DVec3(0.950456, 1, 1.088754), daylight);
}

}  // namespace kinome
