#include "options/interpret_options.h"

#include <algorithm>
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

/// Parses the value of an option, if it is given. CLI11 would replace invalid and large numbers by
/// the nearest one.
template <class T>
void interpret_number(const RawOptions& raw, const std::string& name, T low, T high, T& number) {
  const std::string* const text = raw.find(name);
  if (!text) return;
  const std::string fault = parse_in_range(*text, low, high, number);
  if (!fault.empty()) throw Error(name + ": " + fault);
}

void interpret_seed(const RawOptions& raw, Options& options) {
  interpret_number(raw, "--seed", uint64_t{0}, std::numeric_limits<uint64_t>::max(), options.seed);
}

void interpret_budget(const RawOptions& raw, Options& options) {
  const auto check = [&](const std::string& name, double value) {
    const std::string* const text = raw.find(name);
    if (!text) return;
    if (!(value > 0 && std::isfinite(value))) {
      throw Error(name + ": must be a finite number greater than 0, got " + *text);
    }
    if (options.inspect) throw Error(name + ": " + kNoRender);
  };
  check("--time", options.seconds);
  check("--error", options.rel_mse);
  interpret_number(raw, "--variance", kMinRenders, kMaxRenders, options.renders);
  if (options.renders > 0 && options.inspect) throw Error(std::string("--variance: ") + kNoRender);
}

void check_checkpoint(const RawOptions& raw, const Options& options) {
  if (!raw.find("--checkpoint")) {
    for (const char* name : {"--every", "--resume"}) {
      if (raw.find(name)) throw Error(std::string(name) + ": needs --checkpoint FILE");
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

/// Parses --denoise: "layer", or "true" without a value.
void interpret_denoise(const RawOptions& raw, Options& options) {
  const std::string* const text = raw.find("--denoise");
  if (!text) return;
  if (*text != "layer" && *text != "true") {
    throw Error("--denoise: expected no value, or 'layer', got '" + *text + "'");
  }
  if (options.inspect) throw Error(std::string("--denoise: ") + kNoRender);
  options.denoise = true;
  options.denoise_as_layer = *text == "layer";
}

/// Parses --part: "3/16" or "all/16".
void interpret_part(const RawOptions& raw, Options& options) {
  const std::string* const text = raw.find("--part");
  if (!text) return;
  const size_t slash = std::min(text->find('/'), text->size());
  const std::string part = text->substr(0, slash);
  const auto read = [](const std::string& word, uint32_t high, uint32_t& number) {
    return parse_in_range(word, 1u, high, number).empty();
  };
  const bool is_read = slash < text->size() &&
                       read(text->substr(slash + 1), ImagePart::kMaxParts, options.parts) &&
                       (part == "all" || read(part, options.parts, options.part));
  if (!is_read) {
    throw Error("--part: expected I/N, such as 3/16 for the third of 16 parts (at most " +
                std::to_string(ImagePart::kMaxParts) + "), or all/N, got '" + *text + "'");
  }
  if (options.inspect) throw Error(std::string("--part: ") + kNoRender);
  for (const auto& [name, why] :
       {std::pair("--time", "all parts must have the same number of samples"),
        std::pair("--error", "a part can't estimate the error of the whole image"),
        std::pair("--variance", "parts are rendered independently")}) {
    if (!raw.find(name)) continue;
    throw Error(std::string(name) + ": can't be combined with --part: " + why);
  }
}

/// Parses --crop: X,Y,W,H. The film's size, which limits it, isn't known yet.
void interpret_crop(const RawOptions& raw, Options& options) {
  const std::string* const text = raw.find("--crop");
  if (!text) return;
  const std::vector<std::string> words = split(*text, ',');
  constexpr int kMaxSide = 1 << 16;
  const auto read = [](const std::string& word, int low, int& number) {
    return parse_in_range(word, low, kMaxSide, number).empty();
  };
  int x = 0, y = 0, width = 0, height = 0;
  const bool is_read = std::count(text->begin(), text->end(), ',') == 3 && words.size() == 4 &&
                       read(words[0], 0, x) && read(words[1], 0, y) && read(words[2], 1, width) &&
                       read(words[3], 1, height);
  if (!is_read) {
    throw Error("--crop: expected X,Y,W,H in pixels, such as 200,100,64,48, got '" + *text + "'");
  }
  options.crop = Rect(x, y, x + width, y + height);
}

/// Throws Error for empty values, which CLI11 reads as 0 or ignores.
void check_for_empty_values(const RawOptions& raw) {
  for (const char* const name :
       {"--output", "--every", "--exposure", "--sensor", "--inspect", "--display", "--trace"}) {
    const std::string* const text = raw.find(name);
    if (text && text->empty()) throw Error(std::string(name) + ": its value is empty");
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
  if (const std::string* const text = raw.find("--stats")) {
    if (*text != "json" && *text != "text" && *text != "true") {
      throw Error("--stats: expected 'text' or 'json', got '" + *text + "'");
    }
    options.stats = *text == "json" ? StatsFormat::kJson : StatsFormat::kText;
  }
  if (const std::string* const text = raw.find("--inspect"); text && !text->empty()) {
    int x = 0, y = 0, used = 0;
    if (std::sscanf(text->c_str(), "%d,%d%n", &x, &y, &used) != 2 ||
        used != static_cast<int>(text->size())) {
      throw Error("--inspect: expected a pixel as X,Y, got '" + *text + "'");
    }
    options.inspect = Vec2(x, y);
    if (options.check) throw Error("--inspect: can't be combined with --check");
    if (!options.display.empty()) throw Error(std::string("--display: ") + kNoRender);
    if (options.stats != StatsFormat::kNone) throw Error(std::string("--stats: ") + kNoRender);
    if (!options.trace.empty()) throw Error(std::string("--trace: ") + kNoRender);
  }
  if (options.command == Options::Command::kCheckPlugin) interpret_seed(raw, options);
  if (options.command == Options::Command::kRender || options.command == Options::Command::kFilm) {
    check_for_empty_values(raw);
    interpret_budget(raw, options);
    check_checkpoint(raw, options);
    interpret_seed(raw, options);
    interpret_part(raw, options);
    interpret_crop(raw, options);
  }
  interpret_denoise(raw, options);
  if (const std::string* const text = raw.find("--mpi")) {
    const std::map<std::string, Options::Mpi> modes = {
        {"auto", Options::Mpi::kAuto}, {"on", Options::Mpi::kOn}, {"off", Options::Mpi::kOff}};
    const auto mode = modes.find(*text);
    if (mode == modes.end()) throw Error("--mpi: expected auto, on or off, got '" + *text + "'");
    options.mpi = mode->second;
  }
  if (options.command == Options::Command::kMerge) check_for_empty_values(raw);
  if (options.command == Options::Command::kRelight) {
    check_for_empty_values(raw);
    options.gains = parse_light_gains(raw.gains);
  }
  if (options.command == Options::Command::kFilm) interpret_film(raw, options.film);
  if (raw.find("--isa") && options.isa.empty()) throw Error("--isa: its value is empty");
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
