#pragma once

#include "kinome/color.h"

namespace kinome {

/// Mean of the channels. Measure of importance: errors of all channels have the same weight.
inline float mean_of(const Rgb& c) {
  return (c.x + c.y + c.z) * (1 / 3.f);
}

}  // namespace kinome
