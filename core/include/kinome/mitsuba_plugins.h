#pragma once

#include <span>
#include <string>

#include "kinome/export.h"

namespace kinome {

/// A plugin of Mitsuba 3.9.1.
struct MitsubaPlugin {
  const char* category;  ///< that of Kinome where it has it, else Mitsuba's word
  const char* name;
  /// What it lacks here, though there is a plugin of this name; nullptr: nothing that is known.
  const char* lacks;
};

/// All of them, by category, then by name.
KINOME_EXPORT std::span<const MitsubaPlugin> mitsuba_plugins();
/// Whether Mitsuba has a plugin of this name that may stand for this tag of a scene file.
KINOME_EXPORT bool is_of_mitsuba(const std::string& tag, const std::string& name);

}  // namespace kinome
