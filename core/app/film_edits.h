#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "film_keys.h"
#include "film_options.h"
#include "kinome/scene_editor.h"

namespace kinome::app {

/// What of a scene is edited for each frame of a film. A frame depends on its number and on the
/// scene as it was loaded, not on other frames.
class FilmEdits {
 public:
  /// The scene as it was loaded, of which `sensor` is filmed (an index of Scene::sensors()); `keys`
  /// may be nullptr. Throws Error where the film can't be made of it, as far as that can be told
  /// without any update.
  FilmEdits(const FilmOptions& options, const FilmKeys* keys, const SceneEditor& editor,
            size_t sensor);

  using Values = std::vector<std::pair<std::string, EditedValue>>;
  Values at_frame(int frame) const;
  /// At all keys: where values may be more than a plugin takes.
  std::vector<Values> at_keys() const;
  bool moves_camera() const { return kind_ != Kind::kStill; }

 private:
  enum class Kind { kStill, kOrbit, kEllipse, kKeys };
  Transform place_of_sensor(const SceneEditor& editor) const;
  CameraView view_of(const Sensor& sensor, const Scene& scene) const;
  CameraView view(int frame) const;
  /// From 0 at the first frame to 1 at the last.
  double share(int frame) const;
  void add_camera(const CameraView& camera, const std::string& where, Values& values) const;
  void add_parameters(double share, Values& values) const;

  const FilmOptions& options_;
  const FilmKeys* keys_;
  Kind kind_ = Kind::kStill;
  std::string sensor_path_;
  CameraView start_;                      ///< of the scene's own sensor
  std::vector<FilmKeys::Before> before_;  ///< of each of the keys' tracks
};

}  // namespace kinome::app
