#pragma once

#include <map>
#include <string>
#include <vector>

#include "kinome/relight.h"

namespace kinome::viewer {

/// Factors by which the user changes the light of an image's light groups, without rendering it
/// again.
class LightSliders {
 public:
  static constexpr float kMaxIntensity = 10;

  struct Group {
    std::string name;
    float intensity = 1;
    Rgb color{1.f};  ///< another factor, for each channel
    bool operator==(const Group&) const = default;
  };

  /// Lists the light groups of an image, unless it has none, as a preview. Groups keep their
  /// factors, also while other images are listed. New ones get a factor of 1.
  void follow(const Image& image);
  /// Groups of the last image that had any, whose factors can be changed.
  std::vector<Group>& groups() { return groups_; }
  const std::vector<Group>& groups() const { return groups_; }
  /// Sets all factors to 1.
  void reset();
  /// True if some factor isn't 1 and the image has light groups.
  bool change(const Image& image) const;
  /// Returns the image with changed light: see relight(). The image must have all groups.
  Image relit(const Image& image) const;

 private:
  std::vector<Group> groups_;
  std::map<std::string, Group> factors_;  ///< of all groups listed before, by name
};

}  // namespace kinome::viewer
