#include "session/script.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string_view>
#include <thread>

#include "camera/camera_link.h"
#include "session/put_objects.h"

namespace kinome::viewer {
namespace {

std::vector<double> numbers_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double number; stream >> number;) numbers.push_back(number);
  if (!stream.eof()) throw Error("'" + text + "' is not a list of numbers");
  return numbers;
}

std::vector<double> numbers_of(const std::string& text, size_t count) {
  auto numbers = numbers_of(text);
  if (numbers.size() != count) {
    throw Error("expected " + (count == 1 ? "a number" : std::to_string(count) + " numbers") +
                ", got '" + text + "'");
  }
  return numbers;
}

/// A double represents all integers up to this value exactly.
constexpr int64_t kMaxInteger = int64_t{1} << 53;

int64_t whole_number_of(const std::string& text, int64_t low, int64_t high) {
  const double number = numbers_of(text, 1)[0];
  if (!(number >= static_cast<double>(low) && number <= static_cast<double>(high)) ||
      number != std::floor(number)) {
    throw Error("expected a whole number from " + std::to_string(low) + " to " +
                std::to_string(high) + ", got '" + text + "'");
  }
  return static_cast<int64_t>(number);
}

Vec3 triple_of(const std::string& text) {
  const auto n = numbers_of(text, 3);
  return Vec3(n[0], n[1], n[2]);
}

/// Parses "X Y WIDTH HEIGHT", as for the program's option --crop.
Rect region_of(const std::string& text) {
  const auto n = numbers_of(text, 4);
  constexpr double kMax = 1 << 20;
  for (size_t i = 0; i < 4; ++i) {
    if (!(n[i] >= (i < 2 ? 0 : 1) && n[i] <= kMax && n[i] == std::floor(n[i]))) {
      throw Error("expected X Y WIDTH HEIGHT in pixels, got '" + text + "'");
    }
  }
  const auto x = static_cast<int>(n[0]), y = static_cast<int>(n[1]);
  return {x, y, x + static_cast<int>(n[2]), y + static_cast<int>(n[3])};
}

long resident_bytes() {
  long pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

/// Splits a text at its first spaces and tabs. `rest` is empty if there is only one word.
struct FirstWord {
  explicit FirstWord(const std::string& text) {
    const size_t end = std::min(text.find_first_of(" \t"), text.size());
    const size_t next = std::min(text.find_first_not_of(" \t", end), text.size());
    word = text.substr(0, end);
    rest = text.substr(next);
  }
  std::string word, rest;
};

/// A running script.
class Script {
 public:
  Script(std::string name, RenderSession& session) : name_(std::move(name)), session_(session) {}

  /// Runs a command. Reports errors and returns, so that the script continues.
  void try_to_run(int line, const std::string& command, const std::string& rest) {
    line_ = line;
    try {
      run(command, rest);
    } catch (const std::exception& error) {
      fail(error.what());
    }
  }

  int wait() {
    session_.wait();
    for (const Message& message : session_.messages(known_)) {
      known_ = message.number;
      if (message.is_error) fail(message.text);
    }
    return errors_;
  }

 private:
  void run(const std::string& command, const std::string& rest) {
    if (!rest.empty() && takes_no_value(command)) {
      throw Error("'" + command + "' takes no value, got '" + rest + "'");
    }
    if (rest.empty() && (command == "picture" || command == "save")) {
      throw Error("expected: " + command + " FILE");
    }
    if (command == "set") {
      const FirstWord path(rest);
      if (path.rest.empty()) throw Error("expected: set PATH VALUE");
      set(path.word, path.rest);
    } else if (put(command, rest)) {
      return;
    } else if (command == "undo") {
      session_.undo();
      is_info_outdated_ = true;
    } else if (command == "integrator") {
      session_.set_integrator(rest);
    } else if (command == "denoise") {
      if (rest != "on" && rest != "off") throw Error("expected: denoise on, or denoise off");
      session_.set_denoising(rest == "on");
    } else if (command == "region") {
      session_.set_region(rest.empty() ? std::nullopt : std::optional(region_of(rest)));
    } else if (command == "lookat") {
      std::printf("%s\n", camera().controls().lookat().c_str());
    } else if (move(command, rest)) {
      camera().send(session_);
    } else if (command == "pick") {
      pick(rest);
    } else if (command == "render") {
      session_.render(static_cast<uint32_t>(whole_number_of(rest, 1, 1 << 20)));
    } else if (command == "wait") {
      wait();
    } else if (command == "picture") {
      wait();
      const PicturePointer picture = session_.picture();
      if (!picture) return fail("there is no picture");
      write_picture(rest, *picture);
    } else if (command == "save") {
      session_.save(rest);
      wait();
    } else if (command == "parameters") {
      for (const SceneParameter& parameter : info().parameters) {
        std::printf("%s\t%s\t%s\n", parameter.path.c_str(), parameter.type.c_str(),
                    parameter.plugin.c_str());
      }
    } else if (command == "samples") {
      std::printf("samples %.0f\n", wait_for_samples(rest));
    } else if (command == "sleep") {
      const double seconds = numbers_of(rest, 1)[0];
      if (!(seconds >= 0 && seconds <= 3600)) throw Error("expected seconds, from 0 to 3600");
      std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    } else if (command == "memory") {
      std::printf("memory %ld\n", resident_bytes());
    } else {
      throw Error("unknown command '" + command + "'");
    }
  }

  static bool takes_no_value(const std::string& command) {
    constexpr std::string_view kCommands[] = {"undo", "lookat", "home",
                                              "wait", "parameters", "memory"};
    return std::ranges::find(kCommands, command) != std::end(kCommands);
  }

  /// Waits until the image has the wanted number of samples per pixel; doesn't wait if `wanted` is
  /// empty. Returns the image's number of samples per pixel.
  double wait_for_samples(const std::string& wanted) {
    const int64_t count = wanted.empty() ? 0 : whole_number_of(wanted, 1, 1 << 20);
    while (true) {
      const PicturePointer picture = session_.picture();
      const double samples = picture ? picture->samples : 0;
      const Activity activity = session_.status().activity;
      const bool is_over = activity == Activity::kFailed || activity == Activity::kPaused ||
                           activity == Activity::kFinished;
      if (samples >= static_cast<double>(count) || is_over) return samples;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  const SceneInfo& info() {
    wait();
    info_ = session_.info();
    // The session publishes the description together with the image, or after it.
    while (info_ && info_->served < last_put_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      info_ = session_.info();
    }
    if (!info_) throw Error("the scene isn't loaded");
    is_info_outdated_ = false;
    return *info_;
  }

  const SceneParameter* find(const std::string& path) {
    // Setting values doesn't change which parameters exist.
    const SceneInfo& known = info_ && !is_info_outdated_ ? *info_ : info();
    for (const std::string& whole : {path, path + ".value"}) {
      if (const SceneParameter* const found = known.find(whole)) return found;
      if (const SceneParameter* const found = known.find_textured(whole)) return found;
    }
    return nullptr;
  }

  /// Returns the message about a path that find() hasn't found.
  std::string unknown_parameter(const std::string& path) const {
    std::vector<std::string> paths;
    for (const SceneParameter& parameter : info_->parameters) paths.push_back(parameter.path);
    std::string nearest = nearest_name(path, paths);
    if (nearest.empty()) nearest = nearest_name(path + ".value", paths);
    return "unknown parameter '" + path + "'" + did_you_mean(nearest);
  }

  /// Runs a command that adds or removes objects or restores a parameter. Returns false if it is
  /// another command.
  bool put(const std::string& command, const std::string& rest) {
    const auto& [path, file] = FirstWord(rest);
    const bool takes_file = command == "texture" || command == "normalmap" || command == "bumpmap";
    if (!takes_file && command != "unset" && command != "revert") return false;
    if (path.empty() || takes_file == file.empty()) {
      throw Error("expected: " + command + " PATH" + (takes_file ? " FILE" : ""));
    }
    if (command == "texture") {
      const SceneParameter* const parameter = find(path);
      if (!parameter) {
        fail(unknown_parameter(path));
        return true;
      }
      if (!parameter->kind) throw Error(path + ": an array can't be a texture");
      put(path, file == "checkerboard"
                    ? checkerboard()
                    : bitmap(file, parameter->kind == ParameterType::kUnitlessTexture));
    } else if (takes_file) {
      put(path, map_around(command, file));
    } else {
      put(path, command == "unset" ? EditedValue(Unset{}) : AsWritten{});
    }
    return true;
  }

  void put(const std::string& path, EditedValue value) {
    last_put_ = session_.set({{path, std::move(value)}});
    is_info_outdated_ = true;
  }

  void set(const std::string& path, const std::string& text) {
    const SceneParameter* const parameter = find(path);
    if (!parameter) return fail(unknown_parameter(path));
    is_info_outdated_ |= !parameter->texture.empty();
    try {
      session_.set({{path, parse_value(*parameter, text)}});
    } catch (const Error& error) {
      fail(path + ": " + error.what());
    }
  }

  CameraLink& camera() {
    if (!info_) info();
    camera_.follow(session_, info_);
    while (!camera_.is_aimed()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      camera_.follow(session_, info_);
    }
    if (!camera_.can_move()) throw Error("the sensor can't be moved");
    return camera_;
  }

  /// Moves the camera. Returns false if this is another command.
  bool move(const std::string& command, const std::string& rest) {
    if (command == "orbit" || command == "look") {
      const auto n = numbers_of(rest, 2);
      const Vec2 angle = glm::radians(Vec2(n[0], n[1]));
      CameraControls& controls = camera().controls();
      command == "orbit" ? controls.orbit(angle.x, angle.y) : controls.look(angle.x, angle.y);
    } else if (command == "move") {
      const Vec3 way = triple_of(rest);
      camera().controls().move(way.x, way.y, way.z);
    } else if (command == "dolly") {
      const double factor = numbers_of(rest, 1)[0];
      if (!(factor >= 0.001 && factor <= 1000)) throw Error("expected a factor from 0.001 to 1000");
      camera().controls().dolly(static_cast<float>(factor), camera().is_orthographic());
    } else if (command == "home") {
      camera().controls().reset();
    } else {
      return false;
    }
    return true;
  }

  void pick(const std::string& rest) {
    wait();
    const auto n = numbers_of(rest, 2);
    const auto found = session_.pick(Vec2(n[0], n[1]));
    if (!found) {
      std::printf("nothing\n");
      return;
    }
    std::printf("%g %g %g", found->point.x, found->point.y, found->point.z);
    for (const std::string& material : found->materials) std::printf(" %s", material.c_str());
    std::printf("\n");
  }

  void fail(const std::string& text) {
    std::fprintf(stderr, "kinome-view: %s\n", Error(Location{name_, line_, 1}, text).what());
    ++errors_;
  }

  const std::string name_;
  int line_ = 0;  ///< number of the current line
  RenderSession& session_;
  std::shared_ptr<const SceneInfo> info_;
  bool is_info_outdated_ = false;  ///< the scene may have other parameters than info_
  uint64_t last_put_ = 0;          ///< number of the last request that added or removed objects
  CameraLink camera_;
  uint64_t known_ = 0;
  int errors_ = 0;
};

}  // namespace

EditedValue parse_value(const SceneParameter& parameter, const std::string& text) {
  if (!parameter.kind) throw Error("an array can't be set by a script");
  switch (*parameter.kind) {
    case ParameterType::kBoolean:
      if (text != "true" && text != "false") throw Error("expected true or false");
      return text == "true";
    case ParameterType::kInteger:
      return whole_number_of(text, -kMaxInteger, kMaxInteger);
    case ParameterType::kFloat:
      return numbers_of(text, 1)[0];
    case ParameterType::kString:
    case ParameterType::kFile:
      return text;
    case ParameterType::kFloatOrName:
      try {
        return numbers_of(text, 1)[0];
      } catch (const Error&) {
        return text;
      }
    case ParameterType::kVector:
      return triple_of(text);
    case ParameterType::kEmission:
    case ParameterType::kEmissionTexture:
    case ParameterType::kReflectanceTexture:
    case ParameterType::kUnitlessTexture:
    case ParameterType::kColorTexture:
    case ParameterType::kVolume: {
      const auto n = numbers_of(text);
      if (n.size() == 1) return UniformColor{Rgb(n[0]), false, true};
      return UniformColor{triple_of(text)};
    }
    case ParameterType::kTransform: {
      const auto n = numbers_of(text, 16);
      Mat4 m;
      for (int i = 0; i < 16; ++i) m[i % 4][i / 4] = static_cast<float>(n[static_cast<size_t>(i)]);
      return Transform(m);
    }
    case ParameterType::kImage:
    case ParameterType::kObject:
      break;
  }
  throw Error("it can't be set as text");
}

int run_script(std::istream& script, const std::string& name, RenderSession& session) {
  Script running(name, session);
  std::string line;
  for (int number = 1; std::getline(script, line); ++number) {
    if (line.ends_with('\r')) line.pop_back();
    const size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string::npos || line[begin] == '#') continue;
    line.erase(line.find_last_not_of(" \t") + 1);
    const FirstWord command(line.substr(begin));
    running.try_to_run(number, command.word, command.rest);
  }
  return running.wait();
}

}  // namespace kinome::viewer
