#include "options/option_errors.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include <CLI/CLI.hpp>

#include "kinome/error.h"

namespace kinome::app {
namespace {

using Words = std::vector<std::string>;

/// Returns the first line of CLI11's messages, which may have several.
std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

/// Returns the name of an option: "--spp" for "--spp=4".
std::string name_in(const std::string& word) {
  return word.substr(0, word.find('='));
}

/// Texts about options of other renderers and of other versions of Mitsuba.
using Table = std::vector<std::pair<std::string, Words>>;

/// Returns the text about an option; "" if there is none.
std::string text_about(const std::string& name, const Table& table) {
  for (const auto& [text, names] : table) {
    if (std::find(names.begin(), names.end(), name) != names.end()) return text;
  }
  return "";
}

/// Returns advice on an option that has another name or none in Kinome.
std::string advice_on(const std::string& name) {
  static const Table advice = {
      {"-t COUNT sets the number of threads", {"-p"}},
      {"-q prints no progress", {"-z"}},
      {"leave it out: the size of blocks can't be set", {"-b", "--block-size"}},
      {"leave it out: scenes of Mitsuba 0.4 to 3 are loaded as they are", {"-u", "--update"}},
      {"leave it out: warnings never end a render", {"-w"}},
      {"--checkpoint FILE saves finished tiles", {"-r"}},
      {"--part renders a part of the image, for kinome merge", {"-c"}},
      {"the scene sets the film's size; -D sets parameters of the scene",
       {"--size", "--resolution"}},
      {"--crop X,Y,W,H renders a part of the film", {"--region", "--window", "--crop-window"}},
      {"-D integrator=NAME sets the integrator of scenes that use $integrator", {"-i"}},
      {"leave it out: it is for Mitsuba's LLVM and CUDA variants", {"-O", "-S", "-W", "-V"}},
      {"this build of kinome has no MPI", {"--mpi"}}};
  return text_about(name, advice);
}

/// Returns the scene parameter that has the effect of another renderer's option.
std::string scene_parameter(const std::string& name) {
  static const Table parameters = {
      {"spp", {"--spp", "--samples", "--sample-count", "--sample_count"}},
      {"resx", {"--width", "--resx"}},
      {"resy", {"--height", "--resy"}},
      {"integrator", {"--integrator"}},
      {"max_depth", {"--max-depth", "--max_depth", "--depth"}}};
  return text_about(name, parameters);
}

Words option_names(const CLI::App& app) {
  Words names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

bool has_option(const CLI::App& app, const std::string& name) {
  return app.get_option_no_throw(name) != nullptr;
}

/// The value that is given to the option `word`, by '=' or as the next word; "" if there is none.
std::string value_given(const std::string& word, const Words& words) {
  if (const size_t equals = word.find('='); equals != std::string::npos) {
    return word.substr(equals + 1);
  }
  const auto at = std::find(words.begin(), words.end(), word);
  if (at == words.end() || at + 1 == words.end() || (at + 1)->starts_with("-")) return "";
  return std::filesystem::path(*(at + 1)).extension() == ".xml" ? "" : *(at + 1);
}

std::string unknown_option(const CLI::App& app, const std::string& word, const Words& words) {
  const std::string name = name_in(word);
  const std::string text = "unknown option '" + name + "'";
  // Mitsuba 0.6's "-spp 4", and other renderers' long options with one dash.
  const std::string twice = name.starts_with("--") ? name : "-" + name;
  if (const std::string parameter = scene_parameter(twice);
      !parameter.empty() && has_option(app, "--define")) {
    const std::string value = value_given(word, words);
    return text + " (did you mean '-D " + parameter + "=" + (value.empty() ? "VALUE" : value) +
           "', which sets $" + parameter + " in the scene?)";
  }
  const std::string advice = has_option(app, "--checkpoint") ? advice_on(name) : "";
  if (!advice.empty()) return text + "; " + advice;
  const bool is_letter = name.size() == 2;
  return text + (is_letter ? "" : did_you_mean(nearest_name(twice, option_names(app))));
}

/// Returns the first word that names a long option with one dash, such as "-time", whose letters
/// CLI11 takes for short options; "" if no word does.
std::string long_name_of_one_dash(const CLI::App& app, const Words& words) {
  for (const std::string& word : words) {
    if (word.size() < 3 || word[0] != '-' || word[1] == '-') continue;
    const std::string twice = "-" + name_in(word);
    if (has_option(app, twice) || !scene_parameter(twice).empty()) return word;
  }
  return "";
}

/// Describes a flag whose value is the next word instead of following '='; "" if there is no such
/// flag.
std::string flag_with_value(const CLI::App& app, const Words& words) {
  for (size_t i = 0; i + 1 < words.size(); ++i) {
    if (!words[i].starts_with("--") || words[i + 1].starts_with("-")) continue;
    const CLI::Option* const option = app.get_option_no_throw(words[i]);
    if (!option || !option->get_type_name().starts_with("[=")) continue;
    std::error_code failed;
    if (std::filesystem::exists(words[i + 1], failed)) continue;
    return words[i] + " takes its value after '=': " + words[i] + "=" + words[i + 1];
  }
  return "";
}

/// Describes a definition without a value, which may be the next word, as in "-Dspp 4"; "" if there
/// is no such definition.
std::string empty_define(const CLI::App& app, const Words& words) {
  const CLI::Option* const define = app.get_option_no_throw("--define");
  if (!define) return "";
  for (const std::string& given : define->results()) {
    if (given.find('=') != std::string::npos) continue;
    const std::string text = "-D: expected KEY=VALUE, got '" + given + "'";
    const auto at = std::find_if(words.begin(), words.end(), [&](const std::string& word) {
      return word == given || word == "-D" + given;
    });
    if (at == words.end() || at + 1 == words.end()) return text;
    return text + " (did you mean '-D " + given + "=" + *(at + 1) + "'?)";
  }
  return "";
}

/// Describes a word that no option or argument takes.
std::string describe_extra_word(const CLI::App& app, const std::string& word, const Words& words,
                                const Words& commands) {
  if (word.size() > 1 && word[0] == '-') return unknown_option(app, word, words);
  if (const std::string text = flag_with_value(app, words); !text.empty()) return text;
  if (const std::string text = empty_define(app, words); !text.empty()) return text;
  const CLI::Option* const scene = app.get_option_no_throw("scene.xml");
  if (!scene || scene->results().empty()) return "'" + word + "' was not expected";
  const std::string& first = scene->results().front();
  std::error_code failed;
  if (std::filesystem::exists(first, failed)) {
    return "'" + word + "' was not expected: one command renders one scene, here '" + first + "'";
  }
  if (commands.empty()) return "'" + word + "' was not expected";
  return unknown_command(first, commands);
}

/// Describes the value that an option expects, for values that CLI11 can't convert.
std::string expectation_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  if (type == "COUNT" || type == "N") return "a whole number";
  if (type == "SECONDS") return "a number of seconds";
  return type == "STOPS" ? "a number of stops" : "a number";
}

/// Rewrites CLI11's message "Could not convert: --time = abc".
std::string describe_bad_value(const CLI::App& app, const std::string& text) {
  const std::string start = "Could not convert: ", between = " = ";
  const size_t equals = text.find(between);
  if (!text.starts_with(start) || equals == std::string::npos) return text;
  const std::string name = text.substr(start.size(), equals - start.size());
  const CLI::Option* const option = app.get_option_no_throw(name);
  return name + ": must be " + (option ? expectation_of(*option) : "a number") + ", got '" +
         text.substr(equals + between.size()) + "'";
}

/// Rewrites CLI11's messages "--output: 1 required FILE missing" and "--png was given a disallowed
/// flag override".
std::string describe_bad_count(const std::string& text) {
  const std::string flag_value = " was given a disallowed flag override";
  if (text.ends_with(flag_value)) {
    return "--" + text.substr(0, text.size() - flag_value.size()) + " takes no value";
  }
  const std::string required = ": 1 required ", missing = " missing";
  const size_t at = text.find(required);
  if (at == std::string::npos || !text.ends_with(missing)) return text;
  const size_t begin = at + required.size();
  return text.substr(0, at) +
         " needs a value: " + text.substr(begin, text.size() - missing.size() - begin);
}

}  // namespace

std::string describe_error(const CLI::App& app, const CLI::ParseError& error, const Words& words,
                           const Words& commands) {
  if (const std::string word = long_name_of_one_dash(app, words); !word.empty()) {
    return unknown_option(app, word, words);
  }
  // Report an unknown word before a missing one, because it may be a misspelling of that.
  const Words left = app.remaining();
  const auto option = std::find_if(left.begin(), left.end(),
                                   [](const auto& word) { return word.starts_with('-'); });
  const bool misses = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  const bool has_extras = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  if (option != left.end() && (misses || has_extras)) return unknown_option(app, *option, words);
  if (has_extras && !left.empty()) return describe_extra_word(app, left.front(), words, commands);
  const std::string text = first_line(error.what());
  if (dynamic_cast<const CLI::ConversionError*>(&error)) return describe_bad_value(app, text);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error)) return describe_bad_count(text);
  return text;
}

std::string unknown_command(const std::string& word, const Words& commands) {
  if (std::find(commands.begin(), commands.end(), word) != commands.end()) {
    return "the command '" + word + "' must come first, before its options";
  }
  const std::string text = "unknown command '" + word + "'";
  static const std::map<std::string, const char*> meant = {
      {"help", "--help"}, {"version", "--version"}, {"list", "plugins"}};
  const auto found = meant.find(word);
  const std::string near = found != meant.end() ? found->second : nearest_name(word, commands);
  if (!near.empty()) return text + did_you_mean(near);
  if (word == "render") return text + ": kinome SCENE.xml renders a scene";
  return text + ", and no file of this name";
}

}  // namespace kinome::app
