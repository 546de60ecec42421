#pragma once

#include <string>
#include <utility>
#include <vector>

#include "film/film_keys.h"
#include "kinome/scene_editor.h"
#include "options/options.h"

namespace kinome::app {

/// Edits of a scene for each frame of an animation. A frame depends only on its number and the
/// loaded scene, not on other frames.
class FilmEdits {
 public:
  /// `editor` has the scene as loaded, `sensor` is an index of Scene::sensors(), and `keys` may be
  /// nullptr. Throws Error if a frame is impossible, as far as that can be found without updating
  /// the scene.
  FilmEdits(const FilmOptions& options, const FilmKeys* keys, const SceneEditor& editor,
            size_t sensor);

  using Values = std::vector<std::pair<std::string, EditedValue>>;
  Values at_frame(int frame) const;
  /// Returns the values at each key, for checking that plugins accept them.
  std::vector<Values> at_keys() const;
  bool moves_camera() const { return kind_ != Kind::kStill; }

 private:
  enum class Kind { kStill, kOrbit, kEllipse, kKeys };
  Transform to_world_of_sensor(const SceneEditor& editor) const;
  /// Returns the point that the centre of the image shows.
  glm::dvec3 centre_of_view(const Sensor& sensor, const Scene& scene) const;
  CameraView view(int frame) const;
  /// Returns 0 for the first frame, 1 for the last, and values between for others.
  double share(int frame) const;
  void add_camera(const CameraView& camera, const std::string& where, Values& values) const;
  void add_parameters(double share, Values& values) const;

  const FilmOptions& options_;
  const FilmKeys* keys_;
  Kind kind_ = Kind::kStill;
  std::string sensor_path_;
  CameraView start_;                      ///< view of the scene's own sensor
  std::vector<FilmKeys::Before> before_;  ///< for each track of the keys
};

}  // namespace kinome::app
