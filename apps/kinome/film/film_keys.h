#pragma once

#include <optional>
#include <string>
#include <vector>

#include "film/camera_path.h"
#include "kinome/scene_editor.h"

namespace kinome::app {

/// Keys of an animation's camera and of scene parameters, read from a JSON file:
///
///     {"camera": [{"time": 0, "position": [0, 1, 5], "target": [0, 0, 0], "fov": 40}, ...],
///      "parameters": {"floor.bsdf.alpha": [[0, 0.1], [2, 0.4]],
///                     "sky.to_world": {"axis": [0, 1, 0], "degrees": [[0, 0], [2, 90]]}}}
class FilmKeys {
 public:
  /// Throws Error if the file is invalid. The message has line and column for a syntax error,
  /// otherwise the path within the file: "keys.json: camera[1].position: expected three numbers".
  explicit FilmKeys(const std::string& path);

  /// "orbit" or "ellipse" if `camera` is one of these names, otherwise "".
  const std::string& camera_path() const { return camera_path_; }
  bool has_camera() const { return position_.has_value(); }
  /// Returns the interpolated camera; only if has_camera(). `share` is 0 at the first of all keys
  /// and 1 at the last. `up` is the default for keys without 'up'.
  CameraView camera(double share, const glm::dvec3& up) const;

  /// Curve of one scene parameter.
  struct Track {
    std::string parameter;           ///< path of the parameter
    KeyedCurve curve;                ///< numbers, colours, or angles in degrees
    bool is_color = false;           ///< true for values of three numbers: colours, points, vectors
    std::optional<glm::dvec3> axis;  ///< axis of a rotation through the origin, in world space
  };
  const std::vector<Track>& tracks() const { return tracks_; }
  /// Type and value of a parameter in the loaded scene; nullopt if unknown.
  struct Before {
    std::optional<ParameterType> kind;
    std::optional<EditedValue> value;
  };
  EditedValue value(const Track& track, double share, const Before& before) const;
  /// Returns the positions of all keys, as shares. Values are extreme there, except where a
  /// Catmull-Rom spline overshoots.
  std::vector<double> key_shares() const;

 private:
  double time(double share) const { return first_ + share * (last_ - first_); }

  double first_ = 0, last_ = 0;
  std::string camera_path_;
  std::optional<KeyedCurve> position_, target_, fov_, up_;
  std::vector<Track> tracks_;
};

}  // namespace kinome::app
