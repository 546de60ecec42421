#pragma once

#include <charconv>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "options/options.h"

namespace kinome::app {

/// Values of a command line as text, before they are checked and parsed.
struct RawOptions {
  std::vector<std::string> defines;
  std::vector<std::string> search_paths;
  std::vector<std::string> gains;            ///< GROUP=FACTOR of `kinome relight`
  std::map<std::string, std::string> given;  ///< last value of each option, by "--NAME"

  /// Returns nullptr if the option isn't given.
  const std::string* find(const std::string& name) const {
    const auto found = given.find(name);
    return found == given.end() ? nullptr : &found->second;
  }
};

/// Parses `text` as a number between `low` and `high`; it must be whole if T is an integer type.
/// Returns "" on success, and an error message otherwise.
template <class T>
std::string parse_in_range(const std::string& text, T low, T high, T& number) {
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc{} && rest == text.data() + text.size();
  if (is_number && number >= low && number <= high) return "";
  return fmt::format("must be a {}number between {} and {}, got '{}'",
                     std::is_integral_v<T> ? "whole " : "", low, high, text);
}

/// Parses the arguments of -D, each KEY=VALUE. Throws Error if one is malformed.
std::map<std::string, std::string> parse_defines(const std::vector<std::string>& given);

/// Parses `raw` and adds the values to `options`. Throws Error for invalid values and combinations.
void interpret(const RawOptions& raw, Options& options);
/// Does the same for the options that only `kinome film` has.
void interpret_film(const RawOptions& raw, FilmOptions& film);

}  // namespace kinome::app
