#pragma once

#include <map>
#include <string>
#include <vector>

#include "options/options.h"

namespace kinome::app {

/// Values of a command line as text, before they are checked and parsed.
struct RawOptions {
  std::vector<std::string> defines;
  std::vector<std::string> search_paths;
  std::string stats;
  std::string inspect;
  std::string variance;
  std::string seed;
  std::string mpi;
  std::string part;
  std::string frame, range, target, up, angles;  ///< of `kinome film`
  std::map<std::string, std::string> given;      ///< last value of each option, by "--NAME"
};

/// Parses values KEY=VALUE of -D. Throws Error.
std::map<std::string, std::string> parse_defines(const std::vector<std::string>& given);

/// Parses `raw` and adds the values to `options`. Throws Error for invalid values and combinations.
void interpret(const RawOptions& raw, Options& options);
/// Does so for options of `kinome film` only.
void interpret_film(const RawOptions& raw, FilmOptions& film);

}  // namespace kinome::app
