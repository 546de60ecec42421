#pragma once

#include <memory>
#include <string>
#include <vector>

namespace CLI {
class FormatterBase;
class Option;
}  // namespace CLI

/// Format of `--help`, and parts of it that the manual page shares.
namespace kinome::app {

/// Returns a formatter that lists options by group, with wrapped descriptions.
std::shared_ptr<CLI::FormatterBase> make_help_formatter();

/// Returns all names of an option, short ones first: "-o", "--output". Empty for an argument.
std::vector<std::string> names_of(const CLI::Option& option);
bool takes_value(const CLI::Option& option);
/// Returns the value that follows an option's names: " FILE", "[=COUNT]" if it is optional, or "".
std::string value_of(const CLI::Option& option);

}  // namespace kinome::app
