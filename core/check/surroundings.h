#pragma once

#include <string>

#include "check/subject.h"

namespace kinome::check {

/// Elements of a scene that show a plugin of this XML at work, to the camera of Subject::scene; "":
/// it is not to be looked at in a scene.
std::string surroundings(const Subject& subject, const std::string& xml);

}  // namespace kinome::check
