#include "options/options.h"

#include <filesystem>
#include <iostream>

#include <CLI/CLI.hpp>

#include "kinome/error.h"
#include "options/command_options.h"
#include "options/examples.h"
#include "options/help_format.h"
#include "options/interpret_options.h"
#include "options/option_errors.h"
#include "options/option_pages.h"

namespace kinome::app {
namespace {

std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const Command& known : other_commands()) names.emplace_back(known.word);
  return names;
}

/// Throws Error if the name is no scene file and may be a misspelt command.
void check_scene_name(const std::string& name) {
  if (name.empty()) throw Error("the name of the scene's file is empty");
  const std::filesystem::path path(name);
  std::error_code failed;
  if (std::filesystem::exists(path, failed) || path.has_extension() || path.has_parent_path()) {
    return;
  }
  throw Error(unknown_command(name, command_names()) + " (kinome --help lists the commands)");
}

/// Returns the command and its position in argv, where --plugin-path and --isa may precede it.
/// Returns "" and 0 for rendering.
std::pair<Command, int> command_word(int argc, const char* const* argv) {
  // A link to the program has this name, for scripts of render farms.
  if (argc > 0 && std::filesystem::path(argv[0]).filename() == "kinome-merge") {
    return {merging_command(), 0};
  }
  int i = 1;
  while (i < argc) {
    const std::string_view word = argv[i];
    for (const Command& known : other_commands()) {
      if (word == known.word) return {known, i};
    }
    const std::string_view name = word.substr(0, word.find('='));
    if (name != "--plugin-path" && name != "--isa") break;
    i += word == name ? 2 : 1;
  }
  return {rendering_command(), 0};
}

}  // namespace

/// The options of one command. CLI11 writes their values into `options` and `raw`.
struct OptionsParser::Language {
  explicit Language(const Command& command) {
    app.name(*command.word == 0 ? "kinome" : std::string("kinome ") + command.word);
    app.description(command.description);
    app.formatter(make_help_formatter());
    app.footer(examples_text(command.word));
    command.declare(app, options, raw);
    const bool has_plugins = command.command != Options::Command::kNewPlugin &&
                             command.command != Options::Command::kRelight;
    if (has_plugins) declare_plugin_options(app, options);
    begin_group(app, kProgramGroup);
    if (command.command == Options::Command::kRender) {
      declare_page("--man", "Print the manual page, for man -l", man_page);
      declare_page("--completion", "Print a completion script for bash", bash_completion);
    }
    app.set_version_flag("--version", std::string("kinome " KINOME_VERSION), "Print the version");
    app.set_help_flag("-h,--help", "Print this help");  // now, so that it comes last
  }

  /// Declares a flag that prints a page about all options and ends the program.
  void declare_page(const std::string& name, const std::string& text,
                    std::string (*page)(const CLI::App&, const std::vector<const CLI::App*>&)) {
    const auto print = [this, page] {
      std::vector<std::unique_ptr<Language>> others;
      std::vector<const CLI::App*> commands;
      for (const Command& other : other_commands()) {
        others.push_back(std::make_unique<Language>(other));
        commands.push_back(&others.back()->app);
      }
      std::cout << page(app, commands);
      throw CLI::Success();
    };
    app.add_flag_callback(name, print, text)->disable_flag_override();
  }

  Options options;
  RawOptions raw;
  CLI::App app;
};

OptionsParser::OptionsParser() = default;
OptionsParser::~OptionsParser() = default;

std::optional<Options> OptionsParser::parse(int argc, const char* const* argv) {
  // The first word selects the command, so that a scene may come after any options.
  const auto [command, position] = command_word(argc, argv);
  std::unique_ptr<Language>& language = languages_[command.command];
  if (!language) language = std::make_unique<Language>(command);
  auto& [options, raw, app] = *language;
  options = {};
  raw = {};
  options.command = command.command;
  std::vector<const char*> words(argv, argv + argc);
  if (position > 0) words.erase(words.begin() + position);
  try {
    app.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::Success& success) {
    app.exit(success, std::cout, std::cerr);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    const std::vector<std::string> given(words.begin() + 1, words.end());
    const auto commands = *command.word == 0 ? command_names() : std::vector<std::string>();
    throw Error(describe_error(app, error, given, commands) + " (" + app.get_name() +
                " --help lists the options)");
  }
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    for (const std::string& name : option->get_lnames()) {
      raw.given["--" + name] = option->results().back();
    }
  }
  interpret(raw, options);
  if (command.command == Options::Command::kRender) check_scene_name(options.scene);
  return options;
}

std::optional<Options> parse_options(int argc, const char* const* argv) {
  return OptionsParser().parse(argc, argv);
}

int failure_status_of(int argc, const char* const* argv) {
  return command_word(argc, argv).first.command == Options::Command::kCheckPlugin ? 2 : 1;
}

}  // namespace kinome::app
