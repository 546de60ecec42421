#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

/// The installed manual page and shell completion, generated from the same options as `--help`.
namespace kinome::app {

/// Returns the manual page for man(1), in roff. `render` has the options of `kinome SCENE`, and
/// `commands` those of the other commands, such as `kinome plugins`, which are their names.
std::string man_page(const CLI::App& render, const std::vector<const CLI::App*>& commands);

/// Returns the completion script for bash.
std::string bash_completion(const CLI::App& render, const std::vector<const CLI::App*>& commands);

}  // namespace kinome::app
