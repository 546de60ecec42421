#pragma once

#include <string>
#include <vector>

#include "kit/subject.h"
#include "kinome/error.h"

namespace kinome::check {

/// How a plugin uses the parameters of its table, by name.
struct ParameterUse {
  std::vector<std::string> read;     ///< alone, or together with another parameter
  std::vector<std::string> ignored;  ///< Parameter::ignored
  std::vector<std::string> unread;
  std::vector<std::string> unknown;  ///< the plugin accepted none of the tried values
};
/// Writes each parameter into a scene and loads it. Throws Error if the request is invalid.
KINOME_EXPORT ParameterUse parameter_use(const Request& request);

/// Returns true if the error says that an object didn't read one of its parameters.
bool is_unread(const Error& error);
/// Returns true if the plugin accepts this XML element of the parameter `name` together with some
/// other parameter of its table.
bool is_read_beside_another(const Subject& subject, const std::string& name,
                            const std::string& element);

}  // namespace kinome::check
