#pragma once

#include "loader/node.h"

namespace kinome::loader {

/// From a node of a file older than 2.0.0, whose names are in snake case already, to what Mitsuba 3
/// calls it: tags, colours, plugins and their parameters. Mitsuba 3 itself refuses most of these.
/// What means nothing any more is taken out, which the log tells.
void rename_old(Node& node, Faults& faults);

}  // namespace kinome::loader
