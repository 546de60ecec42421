#pragma once

#include <functional>
#include <string>

#include "check/subject.h"

namespace kinome::check {

/// Whether what the plugin says at many places of a scene fits together, as audit_plugins() finds
/// it after each render; of all faults those that are `wanted`.
Outcome audit(const Subject& subject, const std::function<bool(const std::string&)>& wanted);

}  // namespace kinome::check
