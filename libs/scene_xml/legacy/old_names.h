#pragma once

#include <array>
#include <cstdint>

#include "scene_xml/nodes/node.h"

namespace kinome::loader {

/// Major, minor and patch number of a scene's format.
using Version = std::array<int64_t, 3>;

/// Translates tags, attributes and colours of a node from a file older than 2.0.0. Names must be in
/// snake case already. Mitsuba 3 itself refuses most of the old ones. Plugins and their parameters
/// are translated after substitution, see legacy.h.
void rename_old(Node& node, const Version& version, Faults& faults);

}  // namespace kinome::loader
