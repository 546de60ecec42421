#pragma once

#include <span>

#include "kinome/object.h"

namespace kinome::app {

/// A plugin of Mitsuba 3.9.1.
struct MitsubaPlugin {
  const char* category;  ///< that of Kinome where it has it, else Mitsuba's word
  const char* name;
  /// What it lacks here, though there is a plugin of this name; nullptr: nothing that is known.
  const char* lacks;
};

/// All of them, by category, then by name.
std::span<const MitsubaPlugin> mitsuba_plugins();

}  // namespace kinome::app
