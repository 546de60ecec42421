#include "spectrum.h"

#include <array>

#include <glm/glm.hpp>

#include "kinome/error.h"
#include "numbers.h"

namespace kinome {
namespace {

using DVec3 = glm::dvec3;

constexpr int kFirstWavelength = 360;
constexpr int kLastWavelength = 830;
constexpr int kDaylightStep = 10;

/// CIE standard illuminant D65 (ISO/CIE 11664-2), relative power every 10 nm.
constexpr std::array kDaylight{
    46.6383, 52.0891, 49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008,
    117.812, 114.861, 115.923, 108.811, 109.354, 107.802, 104.79,  107.689, 104.405, 104.046,
    100.0,   96.3342, 95.788,  88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268,
    80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349,  61.604,  69.8856, 75.087,  63.5927,
    46.4182, 66.8054, 63.3828, 64.304,  59.4519, 51.959,  57.4406, 60.3125};
static_assert(kDaylight.size() == (kLastWavelength - kFirstWavelength) / kDaylightStep + 1);

double daylight(double wavelength) {
  const double position = (wavelength - kFirstWavelength) / kDaylightStep;
  const auto i = std::min(static_cast<size_t>(position), kDaylight.size() - 2);
  return glm::mix(kDaylight[i], kDaylight[i + 1], position - static_cast<double>(i));
}

/// A Gaussian with its own width on either side.
double lobe(double wavelength, double height, double centre, double left, double right) {
  const double t = (wavelength - centre) * (wavelength < centre ? left : right);
  return height * std::exp(-0.5 * t * t);
}

/// The CIE 1931 observer, multi-lobe fit of Wyman, Sloan and Shirley 2013 (JCGT 2(2)), eq. 4.
DVec3 observer(double w) {
  return {lobe(w, 0.362, 442.0, 0.0624, 0.0374) + lobe(w, 1.056, 599.8, 0.0264, 0.0323) +
              lobe(w, -0.065, 501.1, 0.0490, 0.0382),
          lobe(w, 0.821, 568.8, 0.0213, 0.0247) + lobe(w, 0.286, 530.9, 0.0613, 0.0322),
          lobe(w, 1.217, 437.0, 0.0845, 0.0278) + lobe(w, 0.681, 459.0, 0.0385, 0.0725)};
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

/// XYZ relative to a constant spectrum of 1, which comes to exactly `white`: the errors of the fit
/// cancel where they would be seen first, in greys.
template <class Illuminant>
Rgb color(const Spectrum& spectrum, const DVec3& white, const Illuminant& illuminant) {
  DVec3 sum(0), whole(0);
  for (int w = kFirstWavelength; w <= kLastWavelength; ++w) {
    const DVec3 weight = observer(w) * illuminant(w);
    sum += weight * value_at(spectrum, w);
    whole += weight;
  }
  return xyz_to_rgb(white * sum / whole);
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

void check_length(const Spectrum& spectrum) {
  if (spectrum.size() < 2) throw Error("a spectrum needs at least two wavelengths");
}

}  // namespace

Spectrum parse_spectrum(const std::string& text) {
  Spectrum spectrum;
  for (const std::string_view part : split_list(text)) {
    const size_t colon = std::min(part.find(':'), part.size());
    append(spectrum, part.substr(0, colon), part.substr(std::min(colon + 1, part.size())));
  }
  check_length(spectrum);
  return spectrum;
}

Spectrum parse_spectrum_file(const std::string& text) {
  Spectrum spectrum;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    line = line.substr(0, line.find('#'));
    const auto columns = split_list(line);
    if (columns.empty()) continue;
    if (columns.size() != 2) {
      throw Error("a line of a spectrum file has a wavelength and a value, not '" +
                  std::string(trim(line)).substr(0, 40) + "'");
    }
    append(spectrum, columns[0], columns[1]);
  }
  check_length(spectrum);
  return spectrum;
}

Rgb emission_color(const Spectrum& spectrum) {
  return color(spectrum, DVec3(1), [](double) { return 1.0; });
}

Rgb reflectance_color(const Spectrum& spectrum) {
  return color(spectrum, DVec3(0.950456, 1, 1.088754), daylight);
}

}  // namespace kinome
