#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace kinome::app {

/// Describes what is wrong with a command line that CLI11 has refused, in terms of its options.
/// `words` is the command line without the program's name. `commands` lists the names of all
/// commands if the command line begins with none of them.
std::string describe_error(const CLI::App& app, const CLI::ParseError& error,
                           const std::vector<std::string>& words,
                           const std::vector<std::string>& commands);

/// Describes a word that is neither a scene file nor a command.
std::string unknown_command(const std::string& word, const std::vector<std::string>& commands);

}  // namespace kinome::app
