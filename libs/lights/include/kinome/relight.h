#pragma once

#include <map>
#include <string>
#include <vector>

#include "kinome/color.h"
#include "kinome/image.h"

namespace kinome {

/// Factors that multiply the light of groups, by the groups' names. Groups without a factor keep
/// their light.
using LightGains = std::map<std::string, Rgb>;

/// Parses factors such as "sun=1.5" or "lamps=0.2,0.3,0.4". Throws Error if a text is malformed or
/// names a group twice.
KINOME_EXPORT LightGains parse_light_gains(const std::vector<std::string>& texts);

/// Returns the names of the light groups whose channels an image has (LightGroups::channels()).
KINOME_EXPORT std::vector<std::string> light_groups_of(const Image& image);

/// Multiplies the light of groups: their channels, and the colour, which becomes the sum of the
/// groups. The result equals a render with the multiplied radiances, up to rounding. All other
/// channels stay as they are. Throws Error if the image lacks a group, or has neither the channels
/// R, G and B nor Y.
KINOME_EXPORT Image relight(Image image, const LightGains& gains);

}  // namespace kinome
