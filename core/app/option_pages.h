#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

/// What is installed beside the program, from the same table of options as `--help`.
namespace kinome::app {

/// The manual page, for man(1), in roff. `render` has the options of `kinome`, and `commands` those of
/// `kinome plugins`, `kinome check` and `kinome new`, which are their names.
std::string man_page(const CLI::App& render, const std::vector<const CLI::App*>& commands);

/// Completion of command lines, for bash.
std::string bash_completion(const CLI::App& render, const std::vector<const CLI::App*>& commands);

}  // namespace kinome::app
