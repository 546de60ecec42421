#pragma once

#include <string>

namespace CLI {
class App;
}

/// What is installed beside the program, from the same table of options as `--help`.
namespace kinome::app {

/// The manual page, for man(1), in roff. `render` and `plugins`: the options of `kinome` and of
/// `kinome plugins`.
std::string man_page(const CLI::App& render, const CLI::App& plugins);

/// Completion of command lines, for bash.
std::string bash_completion(const CLI::App& render, const CLI::App& plugins);

}  // namespace kinome::app
