#pragma once

#include "check/subject.h"
#include "kinome/error.h"

namespace kinome::check {

/// Whether the plugin can be made with the parameters of the request. Error where it can't because
/// of one of these: that is a mistake in the command line, not the plugin's.
bool can_be_made(const Subject& subject);

/// Whether it stands for an exception of a plugin's that is no kinome::Error.
inline bool is_foreign_exception(const Error& error) {
  return error.message().starts_with("plugin '");
}

}  // namespace kinome::check
