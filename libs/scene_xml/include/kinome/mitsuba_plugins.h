#pragma once

#include <span>
#include <string>
#include <string_view>

#include "kinome/export.h"

namespace kinome {

/// Plugin of Mitsuba 3.9.1.
struct MitsubaPlugin {
  std::string_view category;  ///< Kinome's category if it has one, otherwise Mitsuba's
  std::string_view name;
  /// Features missing from Kinome's plugin of the same name; nullptr: none known.
  const char* lacks;
};

/// Returns all plugins of Mitsuba, sorted by category and name.
KINOME_EXPORT std::span<const MitsubaPlugin> mitsuba_plugins();
/// True if Mitsuba has a plugin of this name that may appear in this tag of a scene file.
KINOME_EXPORT bool is_of_mitsuba(const std::string& tag, const std::string& name);

}  // namespace kinome
