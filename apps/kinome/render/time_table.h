#pragma once

#include <string>

#include "kinome/stats.h"

namespace kinome::app {

/// Formats a table with a line per stage, in the order of execution: wall-clock seconds, share of
/// the total, and a description. Parts of a stage are indented and add up to it; a part "other" has
/// the time that no other part accounts for.
std::string time_table(const RenderStats& stats);

}  // namespace kinome::app
