#include "picture/light_sliders.h"

#include <algorithm>
#include <utility>

namespace kinome::viewer {
namespace {

/// Returns the names of the groups of an image that can be relit.
std::vector<std::string> relightable_groups(const Image& image) {
  const bool has_color = image.find_channel("R") >= 0 && image.find_channel("G") >= 0 &&
                         image.find_channel("B") >= 0;
  if (!has_color && image.find_channel("Y") < 0) return {};
  return light_groups_of(image);
}

}  // namespace

void LightSliders::follow(const Image& image) {
  const std::vector<std::string> names = relightable_groups(image);
  if (names.empty()) return;
  for (Group& group : groups_) factors_[group.name] = group;
  groups_.clear();
  for (const std::string& name : names) {
    groups_.push_back(factors_.try_emplace(name, Group{name}).first->second);
  }
}

void LightSliders::reset() {
  for (Group& group : groups_) group = {group.name};
  factors_.clear();
}

bool LightSliders::change(const Image& image) const {
  const bool is_changed = std::ranges::any_of(
      groups_, [](const Group& group) { return group != Group{group.name}; });
  return is_changed && !relightable_groups(image).empty();
}

Image LightSliders::relit(const Image& image) const {
  LightGains gains;
  for (const Group& group : groups_) gains[group.name] = group.intensity * group.color;
  return relight(image, gains);
}

}  // namespace kinome::viewer
