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

std::string man_page(const CLI::App& render, const CLI::App& plugins) {
  return R"(.TH KINOME 1 "" "kinome )" KINOME_VERSION R"(" "User Commands"
.SH NAME
kinome \- renders scenes in Mitsuba's language
.SH SYNOPSIS
.B kinome
.RI [ OPTION ]... " SCENE.xml"
.br
.B kinome plugins
.RI [ OPTION ]... " " [ NAME ]
.SH DESCRIPTION
Renders a scene of Mitsuba 3, or of Mitsuba 0.4 to 0.6, into an OpenEXR or PFM file beside the scene
file. What scenes are made of are plugins;
.B kinome plugins
lists them, those of a category, or the parameters of one.
.SH OPTIONS
)" + options_in_roff(render) +
         R"(.SH OPTIONS OF KINOME PLUGINS
)" + options_in_roff(plugins) +
         R"(.SH EXIT STATUS
.TP
.B 0
The picture is written.
.TP
.B 1
A mistake in the command line, the scene or a file, or something that the machine lacks.
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
.BR kinome\-compare (1),
and the pages in share/doc/kinome beside the program's folder.
)";
}

std::string bash_completion(const CLI::App& render, const CLI::App& plugins) {
  const Words of_render = words_of(render), of_plugins = words_of(plugins);
  // A pattern of nothing would match an empty word.
  const auto pattern = [](const std::string& names) { return names.empty() ? "-" : names; };
  return R"(# Completion of kinome's command lines: made by kinome --completion.
_kinome() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} names
  local lists= i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    [ "${COMP_WORDS[i]}" != plugins ] || lists=yes
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
  if [ -n "$lists" ]; then
    case $word in
      -*) names=')" +
         of_plugins.all + R"(' ;;
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
      [ "$COMP_CWORD" -gt 1 ] || COMPREPLY+=($(compgen -W plugins -- "$word"))
      ;;
  esac
}
complete -F _kinome kinome
)";
}

}  // namespace kinome::app
