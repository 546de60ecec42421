#pragma once

#include "kinome/error.h"
#include "kinome/spectrum.h"
#include "one_color.h"

namespace kinome {

/// Base of spectra by wavelengths.
class SpectrumColor : public OneColor {
 public:
  explicit SpectrumColor(const Spectrum& spectrum)
      : OneColor(reflectance_color(spectrum), emission_color(spectrum)) {}
};

/// What `read` returns; its Error gets the place of parameter `name`.
template <class Read>
Spectrum read_spectrum(const Properties& props, const char* name, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    throw props.error(name, "is no spectrum: " + error.message());
  }
}

}  // namespace kinome
