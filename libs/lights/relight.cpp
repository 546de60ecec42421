#include "kinome/relight.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "kinome/error.h"
#include "kinome/light_groups.h"

namespace kinome {
namespace {

/// Channels R, G and B of a colour, in any order in the image.
struct ColorChannels {
  int index[3];
  Rgb gain{1.f};  ///< factor of a light group

  ColorChannels(const Image& image, const std::string& prefix)
      : index{image.find_channel(prefix + "R"), image.find_channel(prefix + "G"),
              image.find_channel(prefix + "B")} {}
  bool exist() const { return index[0] >= 0 && index[1] >= 0 && index[2] >= 0; }
};

/// Reads the factor at the beginning of a text, and removes it. Returns false if the text begins with
/// something else.
bool read_factor(std::string_view& text, float& factor) {
  constexpr float kMaxFactor = 1e6f;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), factor);
  text.remove_prefix(static_cast<size_t>(rest - text.data()));
  return error == std::errc{} && factor >= 0 && factor <= kMaxFactor;
}

/// Reads one factor, or three with commas between them. Returns false if the text is malformed.
bool read_gain(std::string_view text, Rgb& gain) {
  for (int c = 0; c < 3; ++c) {
    if (!read_factor(text, gain[c])) return false;
    if (c == 0 && text.empty()) {
      gain = Rgb(gain.x);
      return true;
    }
    if (c == 2) return text.empty();
    if (!text.starts_with(',')) return false;
    text.remove_prefix(1);
  }
  return false;
}

std::string channels_prefix(const std::string& group) {
  return LightGroups::kPrefix + group + ".";
}

}  // namespace

LightGains parse_light_gains(const std::vector<std::string>& texts) {
  LightGains gains;
  for (const std::string& text : texts) {
    const size_t equals = text.rfind('=');  // ids of emitters may contain others
    Rgb gain(0.f);
    if (equals == std::string::npos || equals == 0 ||
        !read_gain(std::string_view(text).substr(equals + 1), gain)) {
      throw Error(
          "expected GROUP=FACTOR or GROUP=R,G,B with factors from 0 to 1e6, such as "
          "sun=1.5, got '" +
          text + "'");
    }
    const std::string group = text.substr(0, equals);
    if (!gains.emplace(group, gain).second) throw Error("the group '" + group + "' is given twice");
  }
  return gains;
}

std::vector<std::string> light_groups_of(const Image& image) {
  const std::string prefix = LightGroups::kPrefix, suffix = ".R";
  std::vector<std::string> groups;
  for (const std::string& name : image.channels) {
    if (!name.starts_with(prefix) || !name.ends_with(suffix)) continue;
    if (name.size() <= prefix.size() + suffix.size()) continue;
    const std::string group =
        name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
    if (ColorChannels(image, channels_prefix(group)).exist()) groups.push_back(group);
  }
  return groups;
}

Image relight(Image image, const LightGains& gains) {
  const std::vector<std::string> names = light_groups_of(image);
  for (const auto& [name, gain] : gains) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    throw Error("the image has no light group '" + name + "'" +
                did_you_mean(nearest_name(name, names)));
  }
  const ColorChannels colour(image, "");
  const int luminance_channel = image.find_channel("Y");
  if (!colour.exist() && luminance_channel < 0) {
    throw Error("the image has neither the channels R, G and B nor Y");
  }
  std::vector<ColorChannels> groups;
  for (const std::string& name : names) {
    groups.emplace_back(image, channels_prefix(name));
    if (const auto gain = gains.find(name); gain != gains.end()) groups.back().gain = gain->second;
  }
  const bool is_changed = std::any_of(groups.begin(), groups.end(), [](const ColorChannels& group) {
    return group.gain != Rgb(1.f);
  });
  if (!is_changed) return image;
  const size_t stride = image.channels.size();
  for (size_t at = 0; at < image.data.size(); at += stride) {
    float* const pixel = &image.data[at];
    glm::dvec3 sum(0.);
    for (const ColorChannels& group : groups) {
      for (int c = 0; c < 3; ++c) {
        float& value = pixel[group.index[c]];
        value *= group.gain[c];
        sum[c] += double{value};
      }
    }
    const Rgb relit(sum);
    for (int c = 0; colour.exist() && c < 3; ++c) pixel[colour.index[c]] = relit[c];
    if (!colour.exist()) pixel[luminance_channel] = luminance(relit);
  }
  return image;
}

}  // namespace kinome
