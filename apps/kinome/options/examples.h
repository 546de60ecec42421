#pragma once

#include <span>
#include <string>
#include <string_view>

/// Examples of command lines, for `--help` and the manual page.
namespace kinome::app {

struct Example {
  const char* command;  ///< at most 56 characters, so that it fits into narrow terminals
  const char* phrase;   ///< its effect: "Lists all BSDFs."; at most 54 characters
};
/// Returns the examples of a command: "film", or "" for rendering.
std::span<const Example> examples_of(std::string_view word);
/// Returns them as text for `--help`.
std::string examples_text(std::string_view word);

}  // namespace kinome::app
