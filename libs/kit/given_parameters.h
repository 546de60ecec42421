#pragma once

#include "kit/subject.h"
#include "kinome/error.h"

namespace kinome::check {

/// Returns true if the plugin can be created with the parameters of the request. Throws Error if
/// they are invalid, which is a fault of the command line, not of the plugin.
bool can_be_created(const Subject& subject);

/// Returns true if the error stands for a plugin's exception that isn't a kinome::Error.
inline bool is_foreign_exception(const Error& error) {
  return error.message().starts_with("plugin '");
}

}  // namespace kinome::check
