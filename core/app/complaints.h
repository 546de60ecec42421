#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace kinome::app {

/// Describes what is wrong with a command line that CLI11 has refused, in terms of its options.
/// `words` are those of the command line, without the program's name; `commands` the words that
/// begin other command lines, if this one has no such word.
std::string complaint_of(const CLI::App& app, const CLI::ParseError& error,
                         const std::vector<std::string>& words,
                         const std::vector<std::string>& commands);

/// Describes a word that is neither a scene's file nor a command: 'plugin', say.
std::string unknown_command(const std::string& word, const std::vector<std::string>& commands);

}  // namespace kinome::app
