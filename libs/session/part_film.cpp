// Reads and writes PartFilm as the text of an EXR attribute.

#include "session/part_film.h"

#include <charconv>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>

namespace kinome {
namespace {

/// Highest accepted FilmChannel::power.
constexpr int kMaxPower = 16;

template <class Number>
Number number_of(const std::string& word) {
  Number number{};
  const char* const end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, number);
  if (error != std::errc{} || rest != end) throw std::runtime_error("");
  return number;
}

bool bool_of(const std::string& word) {
  if (word != "0" && word != "1") throw std::runtime_error("");
  return word == "1";
}

void check(const PartFilm& film) {
  bool is_valid = !film.layers.empty() && !film.colors.empty() && !film.component.empty();
  for (const double paths : film.light_paths) is_valid = is_valid && std::isfinite(paths);
  for (const FilmChannel& channel : film.channels) {
    const bool is_layer =
        channel.layer >= 0 && static_cast<size_t>(channel.layer) < film.layers.size();
    is_valid = is_valid && is_layer && channel.value >= FilmChannel::kR &&
               channel.value < static_cast<int>(film.layers[channel.layer].size()) &&
               channel.power >= 1 && channel.power <= kMaxPower;
    if (!is_valid) break;
  }
  if (!is_valid) throw std::runtime_error("");
}

PartFilm read(const std::string& text) {
  PartFilm film;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    const auto word = [&] {
      std::string found;
      if (!(words >> found)) throw std::runtime_error("");
      return found;
    };
    const auto rest = [&] {  // the rest of the line, which may contain spaces
      std::string found;
      words.get();
      std::getline(words, found);
      return found;
    };
    const std::string name = word();
    if (name == "sensor") {
      film.sensor = word();
    } else if (name == "format") {
      film.colors = word();
      film.component = word();
    } else if (name == "response") {
      film.response = number_of<float>(word());
    } else if (name == "non_finite") {
      film.non_finite = number_of<uint64_t>(word());
    } else if (name == "layer") {
      film.light_paths.push_back(number_of<double>(word()));
      film.has_splats.push_back(bool_of(word()));
      film.layers.emplace_back();
    } else if (name == "value" && !film.layers.empty()) {
      film.layers.back().push_back(rest());
    } else if (name == "channel") {
      FilmChannel channel;
      channel.layer = number_of<int>(word());
      channel.value = number_of<int>(word());
      channel.power = number_of<int>(word());
      channel.name = rest();
      film.channels.push_back(channel);
    } else if (name == "hash") {
      film.hash = number_of<uint64_t>(word());
    } else {
      throw std::runtime_error("");
    }
  }
  check(film);
  return film;
}

}  // namespace

std::string text_of(const PartFilm& film) {
  std::string text =
      fmt::format("sensor {}\nformat {} {}\nresponse {}\nnon_finite {}\n", film.sensor, film.colors,
                  film.component, film.response, film.non_finite);
  for (size_t l = 0; l < film.layers.size(); ++l) {
    text += fmt::format("layer {} {}\n", film.light_paths.at(l), film.has_splats.at(l) ? 1 : 0);
    for (const std::string& name : film.layers[l]) text += "value " + name + "\n";
  }
  for (const FilmChannel& channel : film.channels) {
    text += fmt::format("channel {} {} {} {}\n", channel.layer, channel.value, channel.power,
                        channel.name);
  }
  return text + fmt::format("hash {}\n", film.hash);
}

PartFilm part_film_of(const std::string& text) {
  try {
    return read(text);
  } catch (const std::runtime_error&) {
    throw std::runtime_error("damaged: its attribute kinome:part_film is invalid");
  }
}

}  // namespace kinome
