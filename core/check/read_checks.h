#pragma once

#include <string>
#include <vector>

#include "check/subject.h"
#include "kinome/error.h"

namespace kinome::check {

/// How a plugin uses the parameters of its table, by name.
struct ParameterUse {
  std::vector<std::string> read;     ///< alone, or beside another parameter
  std::vector<std::string> ignored;  ///< Parameter::ignored
  std::vector<std::string> unread;
  std::vector<std::string> unknown;  ///< no value that was tried is accepted
};
/// Writes each parameter into a scene and loads it. Throws Error if the request makes no sense.
KINOME_EXPORT ParameterUse parameter_use(const Request& request);

/// Whether an object was refused because it left a parameter unread.
bool is_unread(const Error& error);
/// Whether the plugin accepts this element of the parameter `name` beside some other parameter of
/// its table.
bool is_read_beside_another(const Subject& subject, const std::string& name,
                            const std::string& element);

}  // namespace kinome::check
