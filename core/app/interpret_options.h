#pragma once

#include <map>
#include <string>
#include <vector>

#include "options.h"

namespace kinome::app {

/// A command line as text, before it is checked and taken apart.
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
  std::map<std::string, std::string> given;  ///< by "--NAME": the last value of each that is there
};

/// Of -D: KEY=VALUE. Throws Error.
std::map<std::string, std::string> parse_defines(const std::vector<std::string>& given);

/// Takes apart what is text, and adds it to `options`. Throws Error for values that make no sense, by
/// themselves or together.
void interpret(const RawOptions& raw, Options& options);
/// What is said of a film alone.
void interpret_film(const RawOptions& raw, FilmOptions& film);

}  // namespace kinome::app
