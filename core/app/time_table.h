#pragma once

#include <string>

#include "kinome/stats.h"

namespace kinome::app {

/// Where the time went, for people: a line a stage, in the order in which they run, with its
/// seconds on the clock, its share of the whole, and what it is. Parts of a stage are indented, and
/// add up to it: what no part accounts for is a part of its own.
std::string time_table(const RenderStats& stats);

}  // namespace kinome::app
