#include "film/film_edits.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "kinome/error.h"
#include "kinome/look_at.h"
#include "kinome/scene.h"

namespace kinome::app {
FilmEdits::FilmEdits(const FilmOptions& options, const FilmKeys* keys, const SceneEditor& editor,
                     size_t sensor)
    : options_(options), keys_(keys) {
  const auto scene = editor.scene();
  const std::string& name = keys ? keys->camera_path() : options.path;
  if (name == "orbit") kind_ = Kind::kOrbit;
  if (name == "ellipse") kind_ = Kind::kEllipse;
  if (keys && keys->has_camera()) kind_ = Kind::kKeys;
  if (moves_camera()) {
    sensor_path_ = editor.path_of(*scene->sensors()[sensor]);
    const Transform to_world = to_world_of_sensor(editor);
    start_.up = options.up ? *options.up : glm::dvec3(nearest_axis(to_world.vector({0, 1, 0})));
    if (kind_ != Kind::kKeys) {
      start_.position = glm::dvec3(to_world.point({0, 0, 0}));
      start_.target =
          options.target ? *options.target : centre_of_view(*scene->sensors()[sensor], *scene);
      if (!start_.to_world()) {
        throw Error("--path: the camera can't orbit: it looks along --up, or is at its target");
      }
    }
  }
  const std::vector<SceneParameter> parameters =
      keys && !keys->tracks().empty() ? editor.parameters() : std::vector<SceneParameter>();
  for (size_t i = 0; keys && i < keys->tracks().size(); ++i) {
    const std::string& path = keys->tracks()[i].parameter;
    FilmKeys::Before before;
    try {
      before.value = editor.get(path);
    } catch (const Error& error) {
      throw Error(Location{options.path}, error.what());
    }
    for (const SceneParameter& parameter : parameters) {
      if (parameter.path == path) before.kind = parameter.kind;
    }
    before_.push_back(std::move(before));
  }
  for (int frame = 0; frame < options.frames; ++frame) at_frame(frame);  // throws if invalid
}

Transform FilmEdits::to_world_of_sensor(const SceneEditor& editor) const {
  for (const SceneParameter& parameter : editor.parameters()) {
    if (parameter.path != sensor_path_ + ".to_world" || !parameter.value) continue;
    return std::get<Transform>(*parameter.value);
  }
  throw Error(Location{editor.scene()->file()}, "the sensor has no 'to_world' and can't be moved");
}

glm::dvec3 FilmEdits::centre_of_view(const Sensor& sensor, const Scene& scene) const {
  const Film& film = sensor.film();
  const Vec2 centre(0.5f * static_cast<float>(film.width()),
                    0.5f * static_cast<float>(film.height()));
  std::array<RayHit, 1> hit;
  hit[0].ray = sensor.sample_ray(centre, Vec2(0.5f));
  RenderCounters counters;
  scene.intersect(hit, Coherence::kCoherent, counters);
  if (!hit[0].hit.valid()) {
    throw Error("--path " + options_.path +
                ": no surface to circle at the centre of the image: "
                "set the target by --target X,Y,Z");
  }
  return glm::dvec3(scene.interaction(hit[0]).p);
}

double FilmEdits::share(int frame) const {
  return options_.frames > 1 ? frame / (options_.frames - 1.) : 0;
}

CameraView FilmEdits::view(int frame) const {
  // The animation loops: its first frame would follow its last.
  const double turn = frame / static_cast<double>(options_.frames);
  switch (kind_) {
    case Kind::kOrbit:
      return orbit(start_, turn);
    case Kind::kEllipse:
      return on_ellipse(start_, options_.angles, turn);
    case Kind::kKeys:
      return keys_->camera(share(frame), start_.up);
    case Kind::kStill:
      break;
  }
  return start_;
}

void FilmEdits::add_parameters(double share, Values& values) const {
  for (size_t i = 0; i < before_.size(); ++i) {
    const FilmKeys::Track& track = keys_->tracks()[i];
    values.emplace_back(track.parameter, keys_->value(track, share, before_[i]));
  }
}

void FilmEdits::add_camera(const CameraView& camera, const std::string& where,
                           Values& values) const {
  const auto to_world = camera.to_world();
  if (!to_world) {
    throw Error(fmt::format("--path {}: {} the camera looks along its 'up', or is at its target",
                            options_.path, where));
  }
  values.emplace_back(sensor_path_ + ".to_world", *to_world);
  if (camera.fov) values.emplace_back(sensor_path_ + ".fov", *camera.fov);
}

FilmEdits::Values FilmEdits::at_frame(int frame) const {
  Values values;
  if (moves_camera()) add_camera(view(frame), fmt::format("in frame {}", frame), values);
  if (keys_) add_parameters(share(frame), values);
  return values;
}

std::vector<FilmEdits::Values> FilmEdits::at_keys() const {
  std::vector<Values> all;
  if (!keys_) return all;
  for (const double share : keys_->key_shares()) {
    Values& values = all.emplace_back();
    if (kind_ == Kind::kKeys) add_camera(keys_->camera(share, start_.up), "at a key", values);
    add_parameters(share, values);
  }
  return all;
}

}  // namespace kinome::app
