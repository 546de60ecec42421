// Parses options of `kinome film`.

#include <charconv>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "kinome/error.h"
#include "options/interpret_options.h"

namespace kinome::app {
namespace {

constexpr int kMaxFrames = 1'000'000;

/// Parses numbers such as "1,2.5,-3"; returns nullopt unless they are `count` finite numbers.
std::optional<std::vector<double>> numbers(const std::string& text, size_t count, char separator) {
  std::vector<double> found;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (found.size() < count) {
    double number = 0;
    const auto [rest, error] = std::from_chars(at, end, number);
    if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
    found.push_back(number);
    at = rest;
    if (found.size() == count) break;
    if (at == end || *at++ != separator) return std::nullopt;
  }
  return at == end ? std::optional(found) : std::nullopt;
}

std::optional<glm::dvec3> triple(const RawOptions& raw, const char* name) {
  const std::string* const text = raw.find(name);
  if (!text) return std::nullopt;
  const auto found = numbers(*text, 3, ',');
  if (!found) throw Error(fmt::format("{}: expected X,Y,Z, got '{}'", name, *text));
  return glm::dvec3((*found)[0], (*found)[1], (*found)[2]);
}

void interpret_path(const FilmOptions& film) {
  std::error_code failed;
  if (film.path == "orbit" || film.path == "ellipse") return;
  if (std::filesystem::exists(film.path, failed)) return;
  const std::string near = nearest_name(film.path, std::vector<std::string>{"orbit", "ellipse"});
  throw Error(fmt::format("--path: expected orbit, ellipse or a file of keys, got '{}'{}",
                          film.path, near.empty() ? ": no such file" : did_you_mean(near)));
}

/// Sets the first and last frame to render.
void interpret_range(const RawOptions& raw, FilmOptions& film) {
  film.first = 0;
  film.last = film.frames - 1;
  const std::string *const frame = raw.find("--frame"), *const range = raw.find("--range");
  if (frame && range) throw Error("--frame: can't be combined with --range");
  if (!frame && !range) return;
  const char* const name = frame ? "--frame" : "--range";
  const std::string& text = frame ? *frame : *range;
  const auto found = numbers(text, frame ? 1 : 2, ':');
  const auto is_frame = [&](double i) { return i == std::floor(i) && i >= 0 && i < film.frames; };
  if (!found || !is_frame(found->front()) || !is_frame(found->back()) ||
      found->front() > found->back()) {
    if (film.frames == 1)
      throw Error(fmt::format("{}: the animation has only frame 0, got '{}'", name, text));
    throw Error(fmt::format("{}: expected {} of the frames 0 to {}, got '{}'", name,
                            frame ? "one" : "FIRST:LAST", film.frames - 1, text));
  }
  film.first = static_cast<int>(found->front());
  film.last = static_cast<int>(found->back());
}

}  // namespace

void interpret_film(const RawOptions& raw, FilmOptions& film) {
  interpret_path(film);
  if (film.frames < 1 || film.frames > kMaxFrames) {
    throw Error(fmt::format("--frames: must be between 1 and {}, got {}", kMaxFrames,
                            raw.given.at("--frames")));
  }
  if (!(film.rate > 0 && film.rate <= 1000)) {
    throw Error(
        fmt::format("--fps: must be more than 0 and at most 1000, got {}", raw.given.at("--fps")));
  }
  interpret_range(raw, film);
  film.target = triple(raw, "--target");
  film.up = triple(raw, "--up");
  if (film.up && glm::length(*film.up) == 0) throw Error("--up: must not be zero");
  if (const std::string* const text = raw.find("--angles")) {
    const auto found = numbers(*text, 2, ',');
    const auto is_angle = [](double angle) { return angle >= 0 && angle <= 180; };
    if (!found || !is_angle(found->front()) || !is_angle(found->back())) {
      throw Error(
          fmt::format("--angles: expected A,B in degrees between 0 and 180, got '{}'", *text));
    }
    film.angles = {found->front(), found->back()};
  }
}

}  // namespace kinome::app
