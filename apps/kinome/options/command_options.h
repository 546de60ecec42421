#pragma once

#include <span>

#include "options/interpret_options.h"
#include "options/options.h"

namespace CLI {
class App;
}

/// The commands of the program, and the options of each.
namespace kinome::app {

/// A command, and the word that selects it.
struct Command {
  const char* word;  ///< "" for rendering
  Options::Command command;
  const char* description;
  void (*declare)(CLI::App& app, Options& options, RawOptions& raw);  ///< declares its options
};

const Command& rendering_command();
const Command& merging_command();
/// Returns all commands but rendering.
std::span<const Command> other_commands();

/// Group of the help about the program itself.
inline constexpr const char* kProgramGroup = "Program";
/// Sets the group of the help to which the options declared next belong.
void begin_group(CLI::App& app, const char* name);
/// Declares the options about plugins, which all commands but `kinome new` have.
void declare_plugin_options(CLI::App& app, Options& options);

}  // namespace kinome::app
