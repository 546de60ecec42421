#pragma once

#include "kinome/error.h"
#include "kinome/spectrum.h"
#include "one_color.h"

namespace kinome {

/// Base of spectra that are given by wavelengths.
class SpectrumColor : public OneColor {
 public:
  explicit SpectrumColor(const Spectrum& spectrum)
      : OneColor(reflectance_color(spectrum), emission_color(spectrum)) {}
};

/// Returns read(). If it throws an Error, rethrows it with the location of parameter `name`.
template <class Read>
Spectrum read_spectrum(const Properties& props, const char* name, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    throw props.error(name, "is not a valid spectrum: " + error.message());
  }
}

}  // namespace kinome
