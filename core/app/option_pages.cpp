#include "option_pages.h"

#include <algorithm>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace kinome::app {
namespace {

/// Text for roff: a backslash, a dash that must stay one, and a dot at the beginning mean something
/// to it.
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

/// All names, short ones first: -o, --output.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

bool takes_value(const CLI::Option& option) {
  return option.get_expected_min() > 0;
}

std::string options_in_roff(const CLI::App& app) {
  std::string page;
  for (const CLI::Option* option : app.get_options()) {
    const std::vector<std::string> names = names_of(*option);
    if (names.empty()) continue;
    page += ".TP\n";
    for (size_t i = 0; i < names.size(); ++i) {
      page += (i > 0 ? ", \\fB" : "\\fB") + roff(names[i]) + "\\fR";
    }
    // A flag that may have a value has its "[=COUNT]" for a type.
    // Of "COUNT:INT in [1 - 1024]" the check is left out.
    std::string type = option->get_type_name();
    type = type.substr(0, type.find(':'));
    const bool is_shown = takes_value(*option) || type.starts_with("[=");
    if (is_shown) page += (takes_value(*option) ? " \\fI" : "\\fI") + roff(type) + "\\fR";
    page += "\n" + roff(option->get_description()) + "\n";
  }
  return page;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// What completion knows of a set of options, as variables of bash.
struct Words {
  std::string all;      ///< every name
  std::string files;    ///< a pattern of those whose value is a file
  std::string folders;  ///< a pattern of those whose value is a folder
  std::string others;   ///< a pattern of those with any other value
};

Words words_of(const CLI::App& app) {
  Words words;
  const auto add = [](std::string& list, const std::string& name, char separator) {
    if (!list.empty()) list += separator;
    list += name;
  };
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : names_of(*option)) {
      add(words.all, name, ' ');
      if (!takes_value(*option)) continue;
      const std::string type = option->get_type_name();
      const bool is_folder = type == "FOLDER" || type.starts_with("PATH");
      add(type == "FILE" ? words.files : is_folder ? words.folders : words.others, name, '|');
    }
  }
  return words;
}

}  // namespace

std::string man_page(const CLI::App& render, const std::vector<const CLI::App*>& commands) {
  std::string of_commands;
  for (const CLI::App* command : commands) {
    of_commands += ".SH OPTIONS OF " + upper(command->get_name()) + "\n" + options_in_roff(*command);
  }
  return R"(.TH KINOME 1 "" "kinome )" KINOME_VERSION R"(" "User Commands"
.SH NAME
kinome \- renders scenes in Mitsuba's language
.SH SYNOPSIS
.B kinome
.RI [ OPTION ]... " SCENE.xml"
.br
.B kinome plugins
.RI [ OPTION ]... " " [ NAME ]
.br
.B kinome check
.RI [ OPTION ]... " PLUGIN"
.br
.B kinome new
.RI [ OPTION ]... " CATEGORY NAME"
.SH DESCRIPTION
Renders a scene of Mitsuba 3, or of Mitsuba 0.4 to 0.6, into an OpenEXR or PFM file beside the scene
file. What scenes are made of are plugins;
.B kinome plugins
lists them, those of a category, or the parameters of one,
.B kinome check
finds what is wrong with one, and
.B kinome new
begins one.
.SH OPTIONS
)" + options_in_roff(render) +
         of_commands + R"(.SH EXIT STATUS
.TP
.B 0
The picture is written.
.TP
.B 1
A mistake in the command line, the scene or a file, or something that the machine lacks; of
.BR "kinome check" ,
a plugin that is wrong.
.TP
.B 3
The picture is written, but a plugin gave impossible values; see
.BR \-\-lenient .
.TP
.B 128 + N
Ended by signal N.
.SH ENVIRONMENT
.TP
.B KINOME_PLUGIN_PATH
More folders of plugins, separated by colons.
.TP
.B KINOME_ISA
As
.BR \-\-isa .
.TP
.B COLUMNS
Where lines of help and lists are broken; by default, the width of the terminal.
.SH SEE ALSO
.BR "kinome\-compare \-\-help" ,
and the pages in share/doc/kinome beside the program's folder.
)";
}

std::string bash_completion(const CLI::App& render, const std::vector<const CLI::App*>& commands) {
  const Words of_render = words_of(render);
  std::string words, cases;  // of the commands: their last words, and what options each has
  for (const CLI::App* command : commands) {
    const std::string name = command->get_name();
    const std::string word = name.substr(name.rfind(' ') + 1);
    words += (words.empty() ? "" : " ") + word;
    cases += "        " + word + ") names='" + words_of(*command).all + "' ;;\n";
  }
  std::string any_word = words;
  std::replace(any_word.begin(), any_word.end(), ' ', '|');
  // A pattern of nothing would match an empty word.
  const auto pattern = [](const std::string& names) { return names.empty() ? "-" : names; };
  return R"(# Completion of kinome's command lines: made by kinome --completion.
_kinome() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} names
  local command= i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case ${COMP_WORDS[i]} in
      )" + any_word + R"() command=${COMP_WORDS[i]} ;;
    esac
  done
  COMPREPLY=()
  case $before in
    --isa) COMPREPLY=($(compgen -W 'x86-64-v2 x86-64-v3 x86-64-v4' -- "$word")); return ;;
    )" + pattern(of_render.files) +
         R"() compopt -o filenames; COMPREPLY=($(compgen -f -- "$word")); return ;;
    )" + pattern(of_render.folders) +
         R"() compopt -o filenames; COMPREPLY=($(compgen -d -- "$word")); return ;;
    )" + pattern(of_render.others) +
         R"() return ;;
  esac
  if [ -n "$command" ]; then
    case $word in
      -*)
        case $command in
)" + cases + R"(        esac
        ;;
      *) names=$("${COMP_WORDS[0]}" plugins 2>/dev/null | sed -n 's/^ *\([a-z0-9_]*\).*/\1/p') ;;
    esac
    COMPREPLY=($(compgen -W "$names" -- "$word"))
    return
  fi
  case $word in
    -*) COMPREPLY=($(compgen -W ')" +
         of_render.all + R"(' -- "$word")) ;;
    *)
      compopt -o filenames
      COMPREPLY=($(compgen -f -X '!*.xml' -- "$word") $(compgen -d -- "$word"))
      [ "$COMP_CWORD" -gt 1 ] || COMPREPLY+=($(compgen -W ')" + words + R"(' -- "$word"))
      ;;
  esac
}
complete -F _kinome kinome
)";
}

}  // namespace kinome::app
