#include "checked_scene.h"

#include "kinome/film.h"
#include "kinome/sensor.h"
#include "luck.h"
#include "support/render.h"

namespace kinome::test {

const Scene& CheckedScene::scene_of(const Method& method) {
  auto& scene = scenes_[method.name];
  if (!scene) {
    const size_t at = text_.find("<sensor");
    std::string whole = text_;
    whole.insert(at == std::string::npos ? text_.rfind("</scene") : at,
                 integrator_of(method, text_) + "\n");
    LoadOptions options;
    options.search_paths = {folder_};
    options.threads = 1;
    scene = load_scene_from_string(whole, folder_ + "/scene.xml", options, registry());
  }
  return *scene;
}

bool CheckedScene::is_loaded(const Method& method) const {
  const auto scene = scenes_.find(method.name);
  return scene != scenes_.end() && scene->second;
}

double CheckedScene::samples_of(const Method& method) {
  const Sensor& sensor = *scene_of(method).sensors().at(0);
  return double{1} * sensor.film().crop().area() * sensor.sampler().sample_count();
}

const Renders& CheckedScene::renders_of(const Method& method) {
  auto& renders = renders_[method.name];
  if (renders.pixels.empty()) {
    renders = render_often(scene_of(method), kRenders, first_seed(method));
  }
  return renders;
}

/// Independent estimates use different seeds; methods that are compared seed by seed share one.
uint64_t CheckedScene::first_seed(const Method& method) const {
  if (method.name.starts_with("groundtruth") || method.same_seeds) return 1;
  uint64_t number = 1;
  for (const Method& m : task_.methods) {
    if (&m == &method) break;
    ++number;
  }
  return number * 1000;
}

bool CheckedScene::has_too_much_flux(const Method& method) {
  const bool starts_at_sensor = method.name.starts_with("path") || method.name == "direct" ||
                                method.name == "emitter sampling";
  if (starts_at_sensor) return false;
  const bool follows_sky =
      method.name.starts_with("ptracer") || method.name.ends_with("one bounce");
  if (!has_vast_flux(scene_of(method), follows_sky)) return false;
  report_.excuses.push_back(method.name + ": more flux than single precision holds");
  return true;
}

bool CheckedScene::is_finite(const Method& method, const Renders& renders) {
  if (renders.non_finite == 0) return true;
  if (not_finite_.insert(method.name).second && !has_too_much_flux(method)) {
    report_.findings.push_back(
        {"not finite", method.name, std::to_string(renders.non_finite) + " values"});
  }
  return false;
}

}  // namespace kinome::test
