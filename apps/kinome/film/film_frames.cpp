#include "film/film_frames.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "kinome/error.h"
#include "kinome/output_files.h"
#include "kinome/read_files.h"
#include "output_files/file_writer.h"

namespace kinome::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Describes the first difference between two animations; "" if there is none.
std::string difference(const Checkpoint::Identity& there, const Checkpoint::Identity& own) {
  for (const auto& [name, value] : own) {
    const auto found = there.find(name);
    if (found == there.end()) return name;
    if (found->second == value) continue;
    return name == Checkpoint::kScene
               ? name
               : fmt::format("{}: {} instead of {}", name, found->second, value);
  }
  return "";
}

}  // namespace

FilmFrames::FilmFrames(const std::string& output, const std::string& scene) : pattern_(output) {
  if (output.empty()) pattern_ = fs::path(scene).replace_extension(".mp4").string();
  if (lower_extension(pattern_) == ".mp4") {
    video_ = pattern_;
    pattern_ = fs::path(video_).replace_extension("").string() + "-frames/%04d.png";
  }
  const size_t name = pattern_.rfind('/') + 1;  // npos + 1 is 0
  const size_t begin = pattern_.find('%', name);
  const size_t end = pattern_.find('d', begin);
  const auto fail = [&] {
    throw Error(
        fmt::format("-o {}: expected an .mp4 file, or names of frames with one number, such as "
                    "frames/%04d.exr",
                    output));
  };
  if (begin == std::string::npos || end == std::string::npos ||
      pattern_.find('%', begin + 1) != std::string::npos) {
    fail();
  }
  const std::string digits = pattern_.substr(begin + 1, end - begin - 1);
  const bool is_number = digits.empty() || (digits.size() == 2 && digits[0] == '0' &&
                                            digits[1] >= '1' && digits[1] <= '9');
  if (!is_number) fail();
  digits_ = digits.empty() ? 1 : digits[1] - '0';
  before_ = pattern_.substr(0, begin);
  after_ = pattern_.substr(end + 1);
}

std::string FilmFrames::name(int frame) const {
  return fmt::format("{}{:0{}}{}", before_, frame, digits_, after_);
}

bool FilmFrames::are_png() const {
  return lower_extension(pattern_) == ".png";
}

Output FilmFrames::output(int frame, const Options& options, const Film& film) const {
  if (are_png()) return {"", name(frame)};
  Options of_frame = options;
  of_frame.output = name(frame);
  return choose_output(of_frame, film);
}

std::string FilmFrames::identity_path() const {
  return before_ + "film.json";
}

std::string FilmFrames::folder() const {
  return fs::path(before_ + "x").parent_path().string();
}

void FilmFrames::make_folder() const {
  std::error_code failed;
  if (!folder().empty() && !fs::exists(folder(), failed)) fs::create_directory(folder(), failed);
  check_writable(name(0));  // throws if the folder couldn't be created
}

void FilmFrames::claim(const Checkpoint::Identity& identity, int frames) const {
  const std::string path = identity_path();
  if (!video_.empty()) check_writable(video_);
  for (int i = 0; i < frames; ++i) {
    if (is_read_file(name(i))) check_writable(name(i));  // always throws
  }
  std::error_code failed;
  if (!fs::exists(path, failed)) {
    for (int i = 0; i < frames; ++i) {
      if (!fs::exists(name(i), failed)) continue;
      throw Error(
          fmt::format("-o {}: {} exists, but its animation is unknown (there is no {}): "
                      "remove it, or choose other names",
                      pattern_, name(i), path));
    }
    write_text(path, json(identity).dump(2) + "\n");
    return;
  }
  Checkpoint::Identity there;
  try {
    there = json::parse(file_contents(path)).get<Checkpoint::Identity>();
  } catch (const json::exception&) {
    throw Error(Location{path},
                "invalid file: can't identify the animation of the frames beside it");
  }
  const std::string differing = difference(there, identity);
  if (differing.empty()) return;
  throw Error(
      Location{path},
      fmt::format("the frames beside this file belong to another animation ({}): remove them "
                  "with this file, or choose another -o",
                  differing));
}

bool FilmFrames::exists(const Output& output) {
  const std::vector<std::string> files = output.files();
  return std::all_of(files.begin(), files.end(), [](const std::string& file) {
    std::error_code failed;
    return fs::is_regular_file(file, failed);
  });
}

void FilmFrames::remove(const std::vector<Output>& frames) const {
  std::error_code ignored;
  for (const Output& frame : frames) {
    for (const std::string& file : frame.files()) fs::remove(file, ignored);
  }
  fs::remove(identity_path(), ignored);
  fs::remove(folder(), ignored);  // fails if it isn't empty
}

}  // namespace kinome::app
