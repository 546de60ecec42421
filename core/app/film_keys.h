#pragma once

#include <optional>
#include <string>
#include <vector>

#include "camera_path.h"
#include "kinome/scene_editor.h"

namespace kinome::app {

/// What a film changes from frame to frame, beside a camera that circles: read from a JSON file.
///
///     {"camera": [{"time": 0, "position": [0, 1, 5], "target": [0, 0, 0], "fov": 40}, ...],
///      "parameters": {"floor.bsdf.alpha": [[0, 0.1], [2, 0.4]],
///                     "sky.to_world": {"axis": [0, 1, 0], "degrees": [[0, 0], [2, 90]]}}}
class FilmKeys {
 public:
  /// Throws Error, with line and column where the file is no JSON, and otherwise with the place
  /// within it: "keys.json: camera[1].position: expected three numbers".
  explicit FilmKeys(const std::string& path);

  /// "orbit" or "ellipse" where `camera` is one of these names; "": it isn't.
  const std::string& camera_path() const { return camera_path_; }
  bool has_camera() const { return position_.has_value(); }
  /// `share`: 0 at the first of all keys, 1 at the last. Where has_camera(); `up` is what the keys
  /// leave out.
  CameraView camera(double share, const glm::dvec3& up) const;

  /// One parameter of the scene.
  struct Track {
    std::string parameter;           ///< its path
    KeyedCurve curve;                ///< numbers, colours, or angles in degrees
    bool is_color = false;           ///< or a point, or a vector
    std::optional<glm::dvec3> axis;  ///< what it is turned about, in the world, through its origin
  };
  const std::vector<Track>& tracks() const { return tracks_; }
  /// What the parameter is in the scene.
  struct Before {
    std::optional<ParameterType> kind;
    std::optional<EditedValue> value;
  };
  EditedValue value(const Track& track, double share, const Before& before) const;
  /// Shares of all keys: where values are at their extremes, but for what a spline swings beyond.
  std::vector<double> key_shares() const;

 private:
  double time(double share) const { return first_ + share * (last_ - first_); }

  double first_ = 0, last_ = 0;
  std::string camera_path_;
  std::optional<KeyedCurve> position_, target_, fov_, up_;
  std::vector<Track> tracks_;
};

}  // namespace kinome::app
