#include "options/option_pages.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "kinome/object.h"
#include "options/examples.h"
#include "options/help_format.h"

namespace kinome::app {
namespace {

/// Escapes text for roff, in which backslashes, dashes, and a dot or quote at the beginning are
/// special.
std::string roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
    }
  }
  return !escaped.empty() && (escaped[0] == '.' || escaped[0] == '\'') ? "\\&" + escaped : escaped;
}

std::string options_in_roff(const CLI::App& app) {
  std::string page;
  for (const std::string& group : app.get_groups()) {
    std::string list;
    for (const CLI::Option* option : app.get_options()) {
      const std::vector<std::string> names = names_of(*option);
      if (names.empty() || option->get_group() != group) continue;
      list += ".TP\n";
      for (size_t i = 0; i < names.size(); ++i) {
        list += (i > 0 ? ", \\fB" : "\\fB") + roff(names[i]) + "\\fR";
      }
      const std::string value = value_of(*option);
      if (!value.empty()) list += "\\fI" + roff(value) + "\\fR";
      list += "\n" + roff(option->get_description()) + "\n";
    }
    if (!list.empty()) page += ".SS " + group + "\n" + list;
  }
  return page;
}

std::string examples_in_roff(const std::string& word) {
  std::string page;
  for (const Example& example : examples_of(word)) {
    page += ".TP\n.B " + roff(example.command) + "\n" + roff(example.phrase) + "\n";
  }
  return page;
}

/// Returns the command with its arguments, such as "kinome film [OPTION]... SCENE.xml".
std::string synopsis_in_roff(const CLI::App& app) {
  std::string arguments;
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_positional()) continue;
    const std::string name =
        option->get_name() + (option->get_items_expected_max() > 1 ? "..." : "");
    arguments += option->get_required() ? " " + name : " [" + name + "]";
  }
  return ".B " + app.get_name() + "\n.RI [ OPTION ]... \"" + roff(arguments) + "\"\n";
}

std::string description_in_roff(const CLI::App& app) {
  std::string text = roff(app.get_description());
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text + "\n";
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string names_in_one(const CLI::App& app) {
  std::string all;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : names_of(*option)) all += (all.empty() ? "" : " ") + name;
  }
  return all;
}

/// Returns "plugins" for "kinome plugins", and "" for "kinome".
std::string word_of(const CLI::App& app) {
  const std::string name = app.get_name();
  const size_t space = name.rfind(' ');
  return space == std::string::npos ? "" : name.substr(space + 1);
}

/// Bash patterns that match a command followed by an option, grouped by the type of the option's
/// value.
struct ValuePatterns {
  std::string files;
  std::string folders;
  std::string others;
};

ValuePatterns value_patterns(const std::vector<const CLI::App*>& commands) {
  ValuePatterns patterns;
  for (const CLI::App* command : commands) {
    for (const CLI::Option* option : command->get_options()) {
      if (!takes_value(*option)) continue;
      const std::string type = option->get_type_name();
      const bool is_folder = type == "FOLDER" || type.starts_with("PATH");
      std::string& list = type == "FILE" ? patterns.files
                          : is_folder    ? patterns.folders
                                         : patterns.others;
      for (const std::string& name : names_of(*option)) {
        list += (list.empty() ? "'" : "|'") + word_of(*command) + " " + name + "'";
      }
    }
  }
  return patterns;
}

}  // namespace

std::string man_page(const CLI::App& render, const std::vector<const CLI::App*>& commands) {
  std::string synopsis = synopsis_in_roff(render), description;
  std::string options = ".SH OPTIONS\n" + options_in_roff(render);
  std::string examples = ".SH EXAMPLES\n" + examples_in_roff("");
  for (const CLI::App* command : commands) {
    synopsis += ".br\n" + synopsis_in_roff(*command);
    description += ".PP\n.B " + command->get_name() + ":\n" + description_in_roff(*command);
    options += ".SH OPTIONS OF " + upper(command->get_name()) + "\n" + options_in_roff(*command);
    examples += examples_in_roff(word_of(*command));
  }
  return R"(.TH KINOME 1 "" "kinome )" KINOME_VERSION R"(" "User Commands"
.SH NAME
kinome \- renders scenes in Mitsuba's format
.SH SYNOPSIS
)" + synopsis +
         R"(.SH DESCRIPTION
Renders a scene of Mitsuba 3, or of Mitsuba 0.4 to 0.6, into an OpenEXR or PFM file beside the scene
file.
)" + description +
         options + R"(.SH EXIT STATUS
.TP
.B 0
The image is written.
.TP
.B 1
An error in the command line, the scene or a file, or a missing resource; for
.BR "kinome check" ,
the plugin failed a check.
.TP
.B 2
.B kinome check
couldn't check the plugin: an error in the command line, or a missing resource.
.TP
.B 3
The image is written, but a plugin returned impossible values; see
.BR \-\-lenient .
.TP
.B 128 + N
The program was ended by signal N.
.SH ENVIRONMENT
.TP
.B KINOME_PLUGIN_PATH
Additional plugin folders, separated by colons.
.TP
.B KINOME_ISA
Default of
.BR \-\-isa .
.TP
.B COLUMNS
Width to which help and lists are wrapped; default: the terminal's width.
)" + examples +
         R"(.SH SEE ALSO
.BR "kinome\-compare \-\-help" ,
and the pages in share/doc/kinome beside the program's folder.
)";
}

namespace {

/// The completion script. bash_completion() replaces names such as @WORDS@ by lists.
constexpr const char* kCompletion = R"sh(# Completion of kinome's command lines, generated by kinome --completion.
_kinome() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} names=
  local command= i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case ${COMP_WORDS[i]} in
      @ANY_WORD@) command=${COMP_WORDS[i]} ;;
    esac
  done
  COMPREPLY=()
  case "$command $before" in
    *' --isa') COMPREPLY=($(compgen -W 'x86-64-v2 x86-64-v3 x86-64-v4' -- "$word")); return ;;
    @FILE_OPTIONS@) compopt -o filenames; COMPREPLY=($(compgen -f -- "$word")); return ;;
    @FOLDER_OPTIONS@) compopt -o filenames; COMPREPLY=($(compgen -d -- "$word")); return ;;
    @VALUE_OPTIONS@) return ;;
  esac
  case $word in
    -*)
      case $command in
@CASES@      esac
      COMPREPLY=($(compgen -W "$names" -- "$word"))
      return
      ;;
  esac
  case $command in
    plugins | check)
      # Plugins are indented by two blanks. Only `kinome plugins` accepts a category.
      names=$("${COMP_WORDS[0]}" plugins 2>/dev/null | sed -n 's/^  \([a-z0-9_]\{1,\}\).*/\1/p')
      [ "$command" = check ] || names="$names @CATEGORIES@"
      ;;
    merge | relight)
      compopt -o filenames
      COMPREPLY=($(compgen -f -X '!*.exr' -- "$word") $(compgen -d -- "$word"))
      ;;
    new) [ "$before" != new ] || names='@CATEGORIES@' ;;
    *)
      compopt -o filenames
      COMPREPLY=($(compgen -f -X '!*.xml' -- "$word") $(compgen -d -- "$word"))
      [ "$COMP_CWORD" -gt 1 ] || names='@WORDS@'
      ;;
  esac
  COMPREPLY+=($(compgen -W "$names" -- "$word"))
  if [ "$command" = check ]; then
    compopt -o filenames
    COMPREPLY+=($(compgen -f -X '!*.so' -- "$word") $(compgen -d -- "$word"))
  fi
}
complete -F _kinome kinome
_kinome_merge() {
  # Completes the arguments of `kinome merge`.
  COMP_WORDS=(kinome merge "${COMP_WORDS[@]:1}")
  ((++COMP_CWORD))
  _kinome
}
complete -F _kinome_merge kinome-merge
)sh";

}  // namespace

std::string bash_completion(const CLI::App& render, const std::vector<const CLI::App*>& commands) {
  std::vector<const CLI::App*> all{&render};
  all.insert(all.end(), commands.begin(), commands.end());
  const ValuePatterns values = value_patterns(all);
  std::string words, cases;  // names of the commands, and a case for each with its options
  for (const CLI::App* command : all) {
    const std::string word = word_of(*command);
    if (!word.empty()) words += (words.empty() ? "" : " ") + word;
    cases += "        '" + word + "') names='" + names_in_one(*command) + "' ;;\n";
  }
  std::string any_word = words;
  std::replace(any_word.begin(), any_word.end(), ' ', '|');
  std::string categories;
  for (const Category category : kCategories) {
    categories += (categories.empty() ? "" : " ") + std::string(to_string(category));
  }
  std::string script = kCompletion;
  const std::pair<std::string, std::string> replacements[] = {
      {"@ANY_WORD@", any_word},        {"@FILE_OPTIONS@", values.files},
      {"@FOLDER_OPTIONS@", values.folders}, {"@VALUE_OPTIONS@", values.others},
      {"@CASES@", cases},              {"@CATEGORIES@", categories},
      {"@WORDS@", words}};
  for (const auto& [name, value] : replacements) {
    for (size_t at = script.find(name); at != std::string::npos; at = script.find(name, at)) {
      script.replace(at, name.size(), value);
      at += value.size();
    }
  }
  return script;
}

}  // namespace kinome::app
