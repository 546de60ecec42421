// Reads keys of an animation from a JSON file.

#include "film/film_keys.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "kinome/error.h"
#include "kinome/read_files.h"

namespace kinome::app {
namespace {

using nlohmann::json;
using Key = KeyedCurve::Key;
using Kind = KeyedCurve::Kind;

/// Returns line and column of a byte of a text.
Location location_of(const std::string& file, const std::string& text, size_t byte) {
  const size_t end = std::min(byte, text.size());
  const std::string before = text.substr(0, end);
  const auto lines = std::count(before.begin(), before.end(), '\n');
  const size_t begin = before.rfind('\n') + 1;  // of the line; npos + 1 is 0
  return {file, static_cast<int>(1 + lines), static_cast<int>(1 + end - begin)};
}

/// Parses a text, in which no object may have two values of the same name.
json parse_unique(const std::string& text, const std::string& file) {
  std::vector<std::set<std::string>> names;  // of the objects that are open
  return json::parse(text, [&](int /*depth*/, json::parse_event_t event, const json& parsed) {
    if (event == json::parse_event_t::object_start) names.emplace_back();
    if (event == json::parse_event_t::object_end) names.pop_back();
    if (event == json::parse_event_t::key && !names.back().insert(parsed.get<std::string>()).second) {
      throw Error(Location{file}, fmt::format("the key '{}' is given twice", parsed.get<std::string>()));
    }
    return true;
  });
}

json parse(const std::string& path) {
  const std::string text = file_contents(path);
  try {
    return parse_unique(text, path);
  } catch (const json::out_of_range&) {
    throw Error(Location{path}, "a number is too large");
  } catch (const json::parse_error& error) {
    // The library's message without its number and position.
    std::string what = error.what();
    const size_t words = what.find("syntax error");
    what = words == std::string::npos ? "invalid JSON" : what.substr(words);
    throw Error(location_of(path, text, error.byte > 0 ? error.byte - 1 : 0), what);
  }
}

/// A value in the file, with its path for error messages.
class Part {
 public:
  Part(const json& value, const std::string& file, std::string path)
      : value_(value), file_(file), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(Location{file_}, (path_.empty() ? "" : path_ + ": ") + what);
  }
  const json& value() const { return value_; }
  Part at(size_t i) const { return {value_[i], file_, fmt::format("{}[{}]", path_, i)}; }
  /// Returns nullopt if there is no such value.
  std::optional<Part> find(const std::string& name) const {
    const auto found = value_.find(name);
    if (found == value_.end()) return std::nullopt;
    return Part(*found, file_, (path_.empty() ? "" : path_ + ".") + name);
  }
  Part at(const std::string& name) const {
    auto found = find(name);
    if (!found) fail(fmt::format("'{}' is missing", name));
    return *found;
  }
  void check_object(std::initializer_list<const char*> names) const {
    if (!value_.is_object()) fail("expected an object, { ... }");
    const std::vector<std::string> known(names.begin(), names.end());
    for (const auto& [name, value] : value_.items()) {
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      fail(fmt::format("unknown key '{}'{}", name, did_you_mean(nearest_name(name, known))));
    }
  }
  void check_list(size_t min_size) const {
    if (!value_.is_array() || value_.size() < min_size) {
      fail(fmt::format("expected a list of at least {}", min_size));
    }
  }
  double number() const {
    if (!value_.is_number()) fail("expected a number");
    const double number = value_.get<double>();
    if (!(std::abs(number) <= std::numeric_limits<float>::max())) fail("this number is too large");
    return number;
  }
  glm::dvec3 triple() const {
    if (!value_.is_array() || value_.size() != 3) fail("expected three numbers");
    return {at(0).number(), at(1).number(), at(2).number()};
  }

 private:
  const json& value_;
  const std::string& file_;
  std::string path_;
};

/// Throws Error unless `time` is greater than that of the last key.
void check_time(const std::vector<Key>& before, double time, const Part& part) {
  if (before.empty() || time > before.back().time) return;
  part.fail(fmt::format("times must increase: {:g} comes after {:g}", time, before.back().time));
}

/// Returns the curve of one of the camera's values; nullopt if no key has it.
std::optional<KeyedCurve> camera_curve(const Part& keys, const std::string& name,
                                       bool is_required) {
  std::vector<Key> values;
  for (size_t i = 0; i < keys.value().size(); ++i) {
    const Part key = keys.at(i);
    const double time = key.at("time").number();
    const auto value = is_required ? key.at(name) : key.find(name);
    if (!value) continue;
    check_time(values, time, key);
    values.push_back({time, name == "fov" ? glm::dvec3(value->number()) : value->triple()});
  }
  if (values.empty()) return std::nullopt;
  if (values.size() < keys.value().size()) {
    keys.fail(fmt::format("'{}' must be in all keys, or in none", name));
  }
  return KeyedCurve(std::move(values), Kind::kCatmullRom);
}

/// Reads keys [[time, value], ...]. Values are numbers, or triples if `colors` isn't nullptr; it
/// receives whether they are triples.
std::vector<Key> keys_of(const Part& list, bool* colors) {
  list.check_list(1);
  std::vector<Key> keys;
  const auto is_triple = [](const Part& pair) { return pair.value()[1].is_array(); };
  for (size_t i = 0; i < list.value().size(); ++i) {
    const Part pair = list.at(i);
    if (!pair.value().is_array() || pair.value().size() != 2) pair.fail("expected [time, value]");
    if (i > 0 && is_triple(pair) != is_triple(list.at(0))) {
      pair.fail("expected one number in all keys, or three numbers in all keys");
    }
    const double time = pair.at(0).number();
    check_time(keys, time, pair);
    const bool is_color = colors && is_triple(pair);
    keys.push_back({time, is_color ? pair.at(1).triple() : glm::dvec3(pair.at(1).number())});
    if (colors) *colors = is_color;
  }
  return keys;
}

FilmKeys::Track track_of(const std::string& parameter, const Part& part) {
  if (!part.value().is_object()) {
    bool is_color = false;
    std::vector<Key> keys = keys_of(part, &is_color);
    return {parameter, KeyedCurve(std::move(keys), Kind::kMonotone), is_color, std::nullopt};
  }
  part.check_object({"axis", "degrees"});
  const glm::dvec3 axis = part.at("axis").triple();
  if (glm::length(axis) == 0) part.at("axis").fail("the axis of a rotation can't be zero");
  return {parameter, KeyedCurve(keys_of(part.at("degrees"), nullptr), Kind::kMonotone), false,
          glm::normalize(axis)};
}

}  // namespace

FilmKeys::FilmKeys(const std::string& path) {
  const json all = parse(path);
  const Part root(all, path, "");
  root.check_object({"camera", "parameters"});
  if (const auto camera = root.find("camera")) {
    if (camera->value().is_string()) {
      camera_path_ = camera->value().get<std::string>();
      if (camera_path_ != "orbit" && camera_path_ != "ellipse") {
        camera->fail(
            fmt::format("expected orbit, ellipse or a list of keys, got '{}'", camera_path_));
      }
    } else {
      camera->check_list(1);
      for (size_t i = 0; i < camera->value().size(); ++i) {
        camera->at(i).check_object({"time", "position", "target", "fov", "up"});
      }
      position_ = camera_curve(*camera, "position", true);
      target_ = camera_curve(*camera, "target", true);
      fov_ = camera_curve(*camera, "fov", false);
      up_ = camera_curve(*camera, "up", false);
    }
  }
  if (const auto parameters = root.find("parameters")) {
    if (!parameters->value().is_object()) parameters->fail("expected an object, { ... }");
    for (const auto& [name, value] : parameters->value().items()) {
      tracks_.push_back(track_of(name, parameters->at(name)));
    }
  }
  if (!position_ && camera_path_.empty() && tracks_.empty()) {
    throw Error(Location{path}, "missing keys: neither the camera nor a parameter has any");
  }
  first_ = std::numeric_limits<double>::infinity();
  last_ = -first_;
  const auto include = [this](const KeyedCurve& curve) {
    first_ = std::min(first_, curve.keys().front().time);
    last_ = std::max(last_, curve.keys().back().time);
  };
  if (position_) include(*position_);
  for (const Track& track : tracks_) include(track.curve);
  if (!(first_ <= last_)) first_ = last_ = 0;
}

CameraView FilmKeys::camera(double share, const glm::dvec3& up) const {
  const double at = time(share);
  return {position_->at(at), target_->at(at), up_ ? up_->at(at) : up,
          fov_ ? std::optional(fov_->at(at).x) : std::nullopt};
}

EditedValue FilmKeys::value(const Track& track, double share, const Before& before) const {
  const glm::dvec3 value = track.curve.at(time(share));
  if (track.axis) {
    const auto* const start = before.value ? std::get_if<Transform>(&*before.value) : nullptr;
    const glm::dmat4 turned = glm::rotate(glm::dmat4(1), glm::radians(value.x), *track.axis);
    return Transform(Mat4(turned * glm::dmat4(start ? start->matrix() : Mat4(1.f))));
  }
  if (track.is_color && before.kind == ParameterType::kVector) return Vec3(value);
  if (track.is_color) return UniformColor{Rgb(value), false, false};
  if (before.kind == ParameterType::kInteger) return int64_t{std::llround(value.x)};
  return value.x;
}

std::vector<double> FilmKeys::key_shares() const {
  std::set<double> shares;
  const auto add = [&](const KeyedCurve& curve) {
    for (const Key& key : curve.keys()) {
      shares.insert(last_ > first_ ? (key.time - first_) / (last_ - first_) : 0);
    }
  };
  if (position_) add(*position_);
  for (const Track& track : tracks_) add(track.curve);
  return {shares.begin(), shares.end()};
}

}  // namespace kinome::app
