#include "options/interpret_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <set>

#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/parts.h"

namespace kinome::app {
namespace {

constexpr uint32_t kMinRenders = 4;  ///< a variance from fewer renders is too uncertain
constexpr uint32_t kMaxRenders = 1024;

constexpr const char* kNoRender = "can't be combined with --inspect, which doesn't render";

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  size_t begin = 0;
  while (begin <= text.size()) {
    const size_t end = std::min(text.find(separator, begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

void interpret_budget(const RawOptions& raw, Options& options) {
  const auto check = [&](const std::string& name, double value) {
    if (raw.given.count(name) == 0) return;
    if (!(value > 0 && std::isfinite(value))) {
      throw Error(name + ": must be a finite number greater than 0, got " + raw.given.at(name));
    }
    if (options.inspect) throw Error(name + ": " + kNoRender);
  };
  check("--time", options.seconds);
  check("--error", options.rel_mse);
  if (raw.given.count("--variance") == 0) return;
  const char* const end = raw.variance.data() + raw.variance.size();
  const auto [rest, error] = std::from_chars(raw.variance.data(), end, options.renders);
  if (error != std::errc{} || rest != end || options.renders < kMinRenders ||
      options.renders > kMaxRenders) {
    throw Error("--variance: must be a whole number between " + std::to_string(kMinRenders) +
                " and " + std::to_string(kMaxRenders) + ", got '" + raw.variance + "'");
  }
  if (options.inspect) throw Error(std::string("--variance: ") + kNoRender);
}

void check_checkpoint(const RawOptions& raw, const Options& options) {
  if (raw.given.count("--checkpoint") == 0) {
    for (const char* name : {"--every", "--resume"}) {
      if (raw.given.count(name) > 0) throw Error(std::string(name) + ": needs --checkpoint FILE");
    }
    return;
  }
  if (options.checkpoint.empty()) throw Error("--checkpoint: needs the name of a file");
  if (options.inspect) throw Error(std::string("--checkpoint: ") + kNoRender);
  if (options.seconds > 0) {
    throw Error("--checkpoint: can't resume a render by --time, which depends on the clock");
  }
  if (!(options.every >= 0)) throw Error("--every: must be a number of seconds, 0 or more");
}

/// Parses --seed, because CLI11 replaces invalid and large numbers by the nearest one.
void interpret_seed(const RawOptions& raw, Options& options) {
  if (raw.given.count("--seed") == 0) return;
  const char* const end = raw.seed.data() + raw.seed.size();
  const auto [rest, error] = std::from_chars(raw.seed.data(), end, options.seed);
  if (error == std::errc{} && rest == end) return;
  throw Error("--seed: must be a whole number between 0 and " +
              std::to_string(std::numeric_limits<uint64_t>::max()) + ", got '" + raw.seed + "'");
}

/// Parses --part: "3/16" or "all/16".
void interpret_part(const RawOptions& raw, Options& options) {
  if (raw.given.count("--part") == 0) return;
  const std::string& text = raw.part;
  const size_t slash = std::min(text.find('/'), text.size());
  const bool is_all = text.substr(0, slash) == "all";
  const auto read = [](const char* begin, const char* end, uint32_t& number) {
    const auto [rest, error] = std::from_chars(begin, end, number);
    return error == std::errc{} && rest == end && number > 0;
  };
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  const bool is_read = slash < text.size() && read(begin + slash + 1, end, options.parts) &&
                       (is_all || read(begin, begin + slash, options.part));
  if (!is_read || options.part > options.parts || options.parts > PicturePart::kMaxParts) {
    throw Error("--part: expected I/N, such as 3/16 for the third of 16 parts (at most " +
                std::to_string(PicturePart::kMaxParts) + "), or all/N, got '" + text + "'");
  }
  if (options.inspect) throw Error(std::string("--part: ") + kNoRender);
  for (const auto& [name, why] :
       {std::pair("--time", "all parts must have the same number of samples"),
        std::pair("--error", "a part can't estimate the error of the whole image"),
        std::pair("--variance", "parts are rendered independently")}) {
    if (raw.given.count(name) == 0) continue;
    throw Error(std::string(name) + ": can't be combined with --part: " + why);
  }
}

/// Throws Error for empty values, which CLI11 reads as 0 or ignores.
void check_for_empty_values(const RawOptions& raw) {
  for (const char* const name :
       {"--output", "--every", "--exposure", "--sensor", "--inspect", "--display"}) {
    const auto found = raw.given.find(name);
    if (found != raw.given.end() && found->second.empty()) {
      throw Error(std::string(name) + ": its value is empty");
    }
  }
}

}  // namespace

std::map<std::string, std::string> parse_defines(const std::vector<std::string>& given) {
  std::map<std::string, std::string> defines;
  for (const std::string& define : given) {
    const size_t equals = define.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw Error("-D: expected KEY=VALUE, got '" + define + "'");
    }
    const std::string key = define.substr(0, equals);
    if (!defines.emplace(key, define.substr(equals + 1)).second) {
      throw Error("-D: '" + key + "' is given twice");
    }
  }
  return defines;
}

void interpret(const RawOptions& raw, Options& options) {
  options.defines = parse_defines(raw.defines);
  for (const std::string& paths : raw.search_paths) {
    for (std::string& path : split(paths, ';')) options.search_paths.push_back(std::move(path));
  }
  if (raw.stats == "json") {
    options.stats = StatsFormat::kJson;
  } else if (raw.stats == "text" || raw.stats == "true") {
    options.stats = StatsFormat::kText;
  } else if (!raw.stats.empty()) {
    throw Error("--stats: expected 'text' or 'json', got '" + raw.stats + "'");
  }
  if (!raw.inspect.empty()) {
    int x = 0, y = 0, used = 0;
    if (std::sscanf(raw.inspect.c_str(), "%d,%d%n", &x, &y, &used) != 2 ||
        used != static_cast<int>(raw.inspect.size())) {
      throw Error("--inspect: expected a pixel as X,Y, got '" + raw.inspect + "'");
    }
    options.inspect = Vec2(x, y);
    if (options.check) throw Error("--inspect: can't be combined with --check");
    if (!options.display.empty()) throw Error(std::string("--display: ") + kNoRender);
    if (options.stats != StatsFormat::kNone) throw Error(std::string("--stats: ") + kNoRender);
  }
  if (options.command == Options::Command::kCheckPlugin) interpret_seed(raw, options);
  if (options.command == Options::Command::kRender || options.command == Options::Command::kFilm) {
    check_for_empty_values(raw);
    interpret_budget(raw, options);
    check_checkpoint(raw, options);
    interpret_seed(raw, options);
    interpret_part(raw, options);
  }
  if (raw.given.count("--mpi") > 0) {
    const std::map<std::string, Options::Mpi> modes = {
        {"auto", Options::Mpi::kAuto}, {"on", Options::Mpi::kOn}, {"off", Options::Mpi::kOff}};
    const auto mode = modes.find(raw.mpi);
    if (mode == modes.end()) throw Error("--mpi: expected auto, on or off, got '" + raw.mpi + "'");
    options.mpi = mode->second;
  }
  if (options.command == Options::Command::kMerge) check_for_empty_values(raw);
  if (options.command == Options::Command::kFilm) interpret_film(raw, options.film);
  if (raw.given.count("--isa") > 0 && options.isa.empty()) throw Error("--isa: its value is empty");
  if (!std::isfinite(options.exposure)) throw Error("--exposure: must be a finite number of stops");
}

void warn_of_missing_folders(const Options& options) {
  std::set<std::string> known;
  const auto check = [&known](const std::string& from, const std::vector<std::string>& folders) {
    for (const std::string& folder : folders) {
      std::error_code failed;
      if (std::filesystem::is_directory(folder, failed) || !known.insert(folder).second) continue;
      const bool exists = std::filesystem::exists(folder, failed);
      log_warn(from + " '" + folder + "': " +
               (exists   ? "not a folder"
                : failed ? failed.message()
                         : "no such folder"));
    }
  };
  check("--plugin-path", options.plugin_paths);
  const char* const variable = std::getenv("KINOME_PLUGIN_PATH");
  check("KINOME_PLUGIN_PATH", split(variable ? variable : "", ':'));
  check("--append", options.search_paths);
}

}  // namespace kinome::app
