// Merges an image from the files of its parts.

#include <algorithm>
#include <cstdlib>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "session/fill_gaps.h"
#include "session/part_file.h"
#include "kinome/error.h"
#include "kinome/film_noise.h"
#include "kinome/parts.h"

namespace kinome {
namespace {

constexpr size_t kMaxLanesForNoise = 8;

constexpr const char* kSamples = "kinome:samples";
constexpr const char* kInstructionSet = "kinome:isa";
constexpr const char* kComplete = "kinome:complete";

/// Formats increasing numbers as "1, 3-7 and 9".
std::string ranges_of(const std::vector<uint32_t>& numbers) {
  std::vector<std::string> ranges;
  for (size_t i = 0; i < numbers.size();) {
    size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (last < i + 2) last = i;  // two numbers are not a range
    ranges.push_back(last == i ? std::to_string(numbers[i])
                               : fmt::format("{}-{}", numbers[i], numbers[last]));
    i = last + 1;
  }
  if (ranges.size() < 2) return fmt::format("{}", fmt::join(ranges, ""));
  const std::string last = ranges.back();
  ranges.pop_back();
  return fmt::format("{} and {}", fmt::join(ranges, ", "), last);
}

std::string parts_text(const std::vector<uint32_t>& numbers, uint32_t count) {
  return fmt::format("part{} {} of {}", numbers.size() == 1 ? "" : "s", ranges_of(numbers), count);
}

std::string attribute(const PartHeader& header, const std::string& name) {
  const auto found = header.metadata.find(name);
  return found == header.metadata.end() ? "" : found->second;
}

/// Returns the properties that all parts of an image share: names for messages, and values.
std::vector<std::pair<std::string, std::string>> identity_of(const PartHeader& header) {
  const PartFilm& film = header.film;
  std::string channels;
  for (const auto& names : film.layers) channels += fmt::format("({})", fmt::join(names, " "));
  for (const FilmChannel& c : film.channels) {
    channels += fmt::format(" {}:{}:{}:{}", c.name, c.layer, c.value, c.power);
  }
  const Rect& crop = header.crop;
  return {{"number of parts", std::to_string(header.part.count)},
          {"version", attribute(header, "kinome:version")},
          {"scene", attribute(header, "kinome:scene_hash")},
          {"seed", attribute(header, "kinome:seed")},
          {"integrator", attribute(header, "kinome:integrator")},
          {"sensor", film.sensor},
          {"size", fmt::format("{}x{} at {},{} of {}x{}", crop.width(), crop.height(), crop.x0,
                               crop.y0, header.width, header.height)},
          {"number of samples", attribute(header, kSamples)},
          {"format", film.colors + " " + film.component},
          {"channels", channels},
          {"sensor's response", fmt::format("{}", film.response)}};
}

/// Throws Error if the parts belong to different images.
void check_same_image(const PartHeader& one, const PartHeader& other) {
  const auto expected = identity_of(one), found = identity_of(other);
  for (size_t i = 0; i < expected.size(); ++i) {
    const auto& [name, value] = expected[i];
    const std::string& there = found[i].second;
    if (value == there) continue;
    const std::string what =
        fmt::format("it is not a part of the same image as {}: its {} ", one.path, name);
    if (name == "scene") {
      throw Error(Location{other.path}, what + fmt::format("({}) or its values of -D differ",
                                                           attribute(other, "kinome:scene")));
    }
    throw Error(Location{other.path}, what + fmt::format("is {}, expected {}", there, value));
  }
}

/// Reads the headers and sorts them by part number. Throws Error if the parts don't belong to the
/// same image.
std::vector<PartHeader> read_headers(const std::vector<std::string>& paths) {
  if (paths.empty()) throw Error("no parts to merge");
  std::vector<PartHeader> parts;
  for (const std::string& path : paths) {
    parts.push_back(read_part_header(path));
    check_same_image(parts.front(), parts.back());
  }
  std::stable_sort(parts.begin(), parts.end(), [](const PartHeader& a, const PartHeader& b) {
    return a.part.index < b.part.index;
  });
  for (size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].part.index != parts[i - 1].part.index) continue;
    if (parts[i].path == parts[i - 1].path) throw Error(Location{parts[i].path}, "it is given twice");
    throw Error(Location{parts[i].path},
                fmt::format("it is part {} of {}, and so is {}", parts[i].part.index + 1,
                            parts[i].part.count, parts[i - 1].path));
  }
  return parts;
}

/// Fills MergedParts::count, missing and incomplete.
void find_missing(const std::vector<PartHeader>& parts, MergedParts& merged) {
  merged.count = parts.front().part.count;
  size_t next = 0;
  for (uint32_t i = 0; i < merged.count; ++i) {
    const bool exists = next < parts.size() && parts[next].part.index == i;
    if (!exists) {
      merged.missing.push_back(i + 1);
      continue;
    }
    if (attribute(parts[next], kComplete) != "true") merged.incomplete.push_back(i + 1);
    ++next;
  }
}

void refuse_missing(const MergedParts& merged) {
  const auto refuse = [&](const std::vector<uint32_t>& parts, const char* what) {
    if (parts.empty()) return;
    throw Error(fmt::format("{} {} {}: add --allow-missing to merge the parts that exist",
                            parts_text(parts, merged.count), parts.size() == 1 ? "is" : "are",
                            what));
  };
  refuse(merged.missing, "missing");
  refuse(merged.incomplete, "incomplete, because the render was interrupted");
}

/// Returns the words of an attribute of all parts, without duplicates, in the order in which they
/// first occur.
std::string all_words(const std::vector<PartHeader>& parts, const std::string& name) {
  std::vector<std::string> words;
  std::set<std::string> known;
  for (const PartHeader& part : parts) {
    const std::string text = attribute(part, name);
    for (size_t begin = 0; begin < text.size();) {
      const size_t end = std::min(text.find(' ', begin), text.size());
      const std::string word = text.substr(begin, end - begin);
      if (!word.empty() && known.insert(word).second) words.push_back(word);
      begin = end + 1;
    }
  }
  return fmt::format("{}", fmt::join(words, " "));
}

ImageMetadata merged_metadata(const std::vector<PartHeader>& parts, MergedParts& merged) {
  ImageMetadata metadata = parts.front().metadata;
  for (const char* of_part : {"kinome:filled", "kinome:missing"}) metadata.erase(of_part);
  const std::string samples = attribute(parts.front(), kSamples);
  metadata[kSamples] =
      std::to_string(std::strtoull(samples.c_str(), nullptr, 10) * uint64_t{parts.size()});
  metadata[kInstructionSet] = all_words(parts, kInstructionSet);
  merged.is_mixed = metadata[kInstructionSet] != attribute(parts.front(), kInstructionSet);
  metadata["kinome:plugins"] = all_words(parts, "kinome:plugins");
  const bool is_complete = merged.missing.empty() && merged.incomplete.empty();
  metadata[kComplete] = is_complete ? "true" : "false";
  metadata.merge(metadata_of_parts(merged.count));
  if (!merged.missing.empty()) metadata["kinome:missing_parts"] = ranges_of(merged.missing);
  if (!merged.incomplete.empty())
    metadata["kinome:incomplete_parts"] = ranges_of(merged.incomplete);
  return metadata;
}

/// Estimates the noise of the sum of all parts. Groups of parts are the lanes of a film.
FilmNoise noise_of(const std::vector<PartHeader>& parts, PluginRegistry& registry) {
  const auto lanes = static_cast<uint32_t>(std::min(parts.size(), kMaxLanesForNoise));
  const std::shared_ptr<Film> film = make_film_of_part(parts.front(), registry, lanes);
  for (size_t i = 0; i < parts.size(); ++i) {
    film->set_lane(static_cast<uint32_t>(i * lanes / parts.size()));
    add_part(parts[i], *film);
  }
  return film_noise(*film);
}

}  // namespace

MergedParts merge_parts(const std::vector<std::string>& paths, bool allows_missing,
                        PluginRegistry& registry, bool estimates_noise) {
  const std::vector<PartHeader> parts = read_headers(paths);
  MergedParts merged;
  find_missing(parts, merged);
  if (!allows_missing) refuse_missing(merged);
  merged.film = make_film_of_part(parts.front(), registry);
  // Add the parts in the order of their numbers, because floating-point sums depend on the order.
  for (const PartHeader& part : parts) add_part(part, *merged.film);
  merged.non_finite = merged.film->non_finite();
  merged.image = merged.film->develop();
  const bool is_complete = merged.missing.empty() && merged.incomplete.empty();
  if (!is_complete) {
    const std::vector<bool> gaps = merged.film->gaps(0);
    merged.gaps = static_cast<double>(std::count(gaps.begin(), gaps.end(), true)) /
                  static_cast<double>(gaps.size());
    mark_gaps(*merged.film, merged.image);
  }
  if (estimates_noise && parts.size() > 1) {
    merged.image = with_channels_of(merged.image, noise_of(parts, registry).image);
  }
  merged.metadata = merged_metadata(parts, merged);
  return merged;
}

}  // namespace kinome
