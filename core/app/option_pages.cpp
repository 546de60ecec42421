#include "option_pages.h"

#include <algorithm>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "kinome/object.h"

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
    const std::string type = option->get_type_name();
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

std::string names_in_one(const CLI::App& app) {
  std::string all;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : names_of(*option)) all += (all.empty() ? "" : " ") + name;
  }
  return all;
}

/// "plugins" of "kinome plugins", "" of "kinome".
std::string word_of(const CLI::App& app) {
  const std::string name = app.get_name();
  const size_t space = name.rfind(' ');
  return space == std::string::npos ? "" : name.substr(space + 1);
}

/// By what bash may complete the values of options: patterns of a command's word and an option.
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
.B kinome film
.RI [ OPTION ]... " SCENE.xml"
.br
.B kinome merge
.RI [ OPTION ]... " PART.exr... " \-o " FILE"
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
file.
.B kinome film
renders a film of a scene, and
.B kinome merge
(or
.BR kinome\-merge )
adds the parts of a picture that were rendered by themselves. Scenes are made of plugins:
.B kinome plugins
lists them, those of a category, or the parameters of one,
.B kinome check
finds out what is wrong with one, and
.B kinome new
starts a new one.
.SH OPTIONS
)" + options_in_roff(render) +
         of_commands + R"(.SH EXIT STATUS
.TP
.B 0
The picture is written.
.TP
.B 1
A mistake in the command line, the scene or a file, or something that the machine lacks; for
.BR "kinome check" ,
the plugin is wrong.
.TP
.B 2
.B kinome check
couldn't check the plugin: a mistake in the command line, or something that the machine lacks.
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
The width to which help and lists are wrapped; by default, that of the terminal.
.SH SEE ALSO
.BR "kinome\-compare \-\-help" ,
and the pages in share/doc/kinome beside the program's folder.
)";
}

std::string bash_completion(const CLI::App& render, const std::vector<const CLI::App*>& commands) {
  std::vector<const CLI::App*> all{&render};
  all.insert(all.end(), commands.begin(), commands.end());
  const ValuePatterns values = value_patterns(all);
  std::string words, cases;  // of the commands: their words, and what options each has
  for (const CLI::App* command : all) {
    const std::string word = word_of(*command);
    if (!word.empty()) words += (words.empty() ? "" : " ") + word;
    cases += "        '" + word + "') names='" + names_in_one(*command) + "' ;;\n";
  }
  std::string any_word = words;
  std::replace(any_word.begin(), any_word.end(), ' ', '|');
  std::string categories;
  for (int i = 0; i < kCategoryCount; ++i) {
    categories += (i > 0 ? " " : "") + std::string(to_string(static_cast<Category>(i)));
  }
  return R"(# Completion of kinome's command lines: made by kinome --completion.
_kinome() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} names=
  local command= i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case ${COMP_WORDS[i]} in
      )" + any_word + R"() command=${COMP_WORDS[i]} ;;
    esac
  done
  COMPREPLY=()
  case "$command $before" in
    *' --isa') COMPREPLY=($(compgen -W 'x86-64-v2 x86-64-v3 x86-64-v4' -- "$word")); return ;;
    )" + values.files +
         R"() compopt -o filenames; COMPREPLY=($(compgen -f -- "$word")); return ;;
    )" + values.folders +
         R"() compopt -o filenames; COMPREPLY=($(compgen -d -- "$word")); return ;;
    )" + values.others +
         R"() return ;;
  esac
  case $word in
    -*)
      case $command in
)" + cases + R"(      esac
      COMPREPLY=($(compgen -W "$names" -- "$word"))
      return
      ;;
  esac
  case $command in
    plugins | check)
      # Plugins are indented by two blanks; of categories only the first of the two commands knows.
      names=$("${COMP_WORDS[0]}" plugins 2>/dev/null | sed -n 's/^  \([a-z0-9_]\{1,\}\).*/\1/p')
      [ "$command" = check ] || names="$names )" + categories + R"("
      ;;
    merge)
      compopt -o filenames
      COMPREPLY=($(compgen -f -X '!*.exr' -- "$word") $(compgen -d -- "$word"))
      ;;
    new) [ "$before" != new ] || names=')" + categories + R"(' ;;
    *)
      compopt -o filenames
      COMPREPLY=($(compgen -f -X '!*.xml' -- "$word") $(compgen -d -- "$word"))
      [ "$COMP_CWORD" -gt 1 ] || names=')" + words + R"('
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
  # As the arguments of `kinome merge`.
  COMP_WORDS=(kinome merge "${COMP_WORDS[@]:1}")
  ((++COMP_CWORD))
  _kinome
}
complete -F _kinome_merge kinome-merge
)";
}

}  // namespace kinome::app
