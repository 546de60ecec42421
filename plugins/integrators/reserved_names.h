#pragma once

#include <algorithm>
#include <iterator>
#include <string_view>

namespace kinome {

/// First parts of the names of channels that the program adds to an image ("variance.R"), or that
/// it reads in a special way. Integrators must not give these names to other channels.
inline constexpr std::string_view kReservedNames[] = {"variance", "tile_variance", "noisy",
                                                      "denoised", "lights"};
/// Beginning of the names of layers of Cryptomatte.
inline constexpr std::string_view kReservedPrefix = "Crypto";

/// Returns true if channels "NAME.SUFFIX" have a reserved name.
constexpr bool is_reserved(std::string_view name) {
  const std::string_view first = name.substr(0, name.find('.'));
  return name.starts_with(kReservedPrefix) ||
         std::find(std::begin(kReservedNames), std::end(kReservedNames), first) !=
             std::end(kReservedNames);
}

}  // namespace kinome
