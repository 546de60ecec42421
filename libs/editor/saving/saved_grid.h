#pragma once

#include <string>

#include "kinome/image.h"

namespace kinome::loader {

/// Returns the contents of a file in Mitsuba's format .vol with the values of a grid, whose slices
/// follow one another in the rows of `grid`. Its box is the unit cube.
std::string saved_grid(const Image& grid, int slices);

}  // namespace kinome::loader
