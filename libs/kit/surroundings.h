#pragma once

#include <string>

#include "kit/subject.h"

namespace kinome::check {

/// Returns the elements of a scene that uses the plugin of this XML element, for the camera of
/// Subject::scene(). Returns "" for categories that aren't checked in a scene.
std::string surroundings(const Subject& subject, const std::string& xml);

}  // namespace kinome::check
