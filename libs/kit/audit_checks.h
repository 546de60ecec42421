#pragma once

#include <functional>
#include <string>

#include "kit/subject.h"

namespace kinome::check {

/// Checks with audit_plugins(), at many points of a scene, whether the plugin's functions agree
/// with one another. Reports only faults for which `wanted` returns true.
Outcome audit(const Subject& subject, const std::function<bool(const std::string&)>& wanted);

}  // namespace kinome::check
