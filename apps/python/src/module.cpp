// The compiled Python module kinome._kinome, on which kinome/__init__.py is built.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "kinome/cryptomatte.h"
#include "kinome/inspection.h"
#include "kinome/log.h"
#include "denoise.h"
#include "pictures.h"
#include "plugin_list.h"
#include "queries.h"
#include "rendering.h"
#include "scene_queries.h"
#include "values.h"

namespace kinome::python {
namespace {

/// Returns kinome.Error, or None before set_up() is called.
nb::object& error_class() {
  static nb::object* const found = new nb::object(nb::none());
  return *found;
}

nb::object as_python(const Error& error) {
  return error_class()(error.what(), error.message(), error.where().file, error.where().line,
                       error.where().column);
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    nb::object all = as_python(error);
    if (const auto* const errors = dynamic_cast<const Errors*>(&error)) {
      nb::list list;
      for (const Error& one : errors->all()) list.append(as_python(one));
      all.attr("all") = list;
    }
    PyErr_SetObject(error_class().ptr(), all.ptr());
  }
}

/// A scene that one thread at a time can render or edit.
class Editor {
 public:
  Editor(const std::string& path, const std::map<std::string, std::string>& defines,
         const std::vector<std::string>& folders, bool lenient) {
    const Turn turn(plugins().mutex);
    editor_ = std::make_unique<SceneEditor>(
        path, LoadOptions{.defines = defines, .search_paths = folders, .lenient = lenient},
        plugins().get(), &stats_);
  }
  Editor(const std::string& xml, const std::string& name,
         const std::map<std::string, std::string>& defines,
         const std::vector<std::string>& folders, bool lenient) {
    const Turn turn(plugins().mutex);
    editor_ = std::make_unique<SceneEditor>(
        xml, name, LoadOptions{.defines = defines, .search_paths = folders, .lenient = lenient},
        plugins().get(), &stats_);
  }
  Editor(nb::handle description, const std::vector<std::string>& folders) {
    const ObjectDescription scene = to_description(description);
    const Turn turn(plugins().mutex);
    editor_ = std::make_unique<SceneEditor>(
        scene, LoadOptions{.defines = {}, .search_paths = folders}, plugins().get(), &stats_);
  }

  nb::list parameters() const {
    nb::list all;
    for (const SceneParameter& p : editor().parameters()) {
      all.append(nb::make_tuple(p.path, p.type, p.plugin, p.doc, p.choices, from_value(p.value),
                                from_value(p.default_value), p.is_set, p.low, p.high));
    }
    return all;
  }
  nb::object get(const std::string& path) const { return from_value(editor().get(path)); }
  void set(const std::string& path, nb::handle value) {
    editor().set(path, to_value(value, Location{path}));
  }
  /// Sets pairs of paths and values: all of them, or none if one is invalid.
  void set_all(const nb::list& pairs) {
    std::vector<std::pair<std::string, EditedValue>> values;
    for (const nb::handle pair : pairs) {
      const auto path = nb::cast<std::string>(pair[0]);
      values.emplace_back(path, to_value(pair[1], Location{path}));
    }
    editor().set(std::move(values));
  }
  void unset(const std::string& path) { editor().set(path, Unset()); }
  void revert(const std::string& path) { editor().set(path, AsWritten()); }
  nb::list objects() const {
    nb::list all;
    for (const SceneObject& o : editor().objects()) {
      all.append(nb::make_tuple(o.path, o.plugin, o.is_around));
    }
    return all;
  }
  /// Returns the plugin of the object with a path that objects() lists.
  std::string plugin(const std::string& path) const {
    const auto found = editor().object_at(path);
    if (!found) throw Error("there is no object '" + path + "' in the scene");
    return found->plugin;
  }
  nb::list textures() const {
    nb::list all;
    for (const SceneParameter& p : editor().textured_parameters()) {
      all.append(nb::make_tuple(p.path, p.texture));
    }
    return all;
  }
  void save(const std::string& path) const { editor().save(path); }
  std::vector<std::string> sensors() const { return sensor_paths(editor()); }
  std::vector<std::string> shapes() const { return shape_paths(editor()); }
  std::vector<std::string> emitters() const { return emitter_paths(editor()); }
  std::vector<std::string> hit_shapes(const HeldScene& held) const {
    for (const FormerScene& former : former_) {
      if (former.scene.lock() == held.scene) return former.shapes;
    }
    return hit_shape_paths(editor(), *held.scene);
  }
  std::string environment() const { return environment_path(editor()); }
  std::map<std::string, std::string> parts(const std::string& path) const {
    return part_paths(editor(), path);
  }
  nb::object bounds(const std::string& path) const { return bounds_of(editor(), path); }
  float max_coordinate() {
    if (const auto scene = editor().scene(); measured_.lock() != scene) {
      max_coordinate_ = max_ray_coordinate_of(*editor_);
      measured_ = scene;
    }
    return max_coordinate_;
  }
  float relative_index(const std::string& path) const { return relative_index_of(editor(), path); }
  nb::tuple filter(const std::string& path, size_t count) const {
    return filter_values(editor(), path, count);
  }
  /// Returns a member function that calls a function of queries.h with the scene.
  template <class Result, class... Arguments>
  static auto query(Result (*function)(const SceneEditor&, Arguments...)) {
    return [function](Editor& self, Arguments... arguments) -> Result {
      const Reading reading(self);
      return function(*self.editor_, std::forward<Arguments>(arguments)...);
    };
  }
  nb::tuple update() {
    const Use use(*this);
    std::erase_if(former_, [](const FormerScene& former) { return former.scene.expired(); });
    const auto before = editor_->scene();
    FormerScene former{before, {}};
    // The editor and `before` have the scene. Surface points may have it, too.
    if (before.use_count() > 2) former.shapes = hit_shape_paths(*editor_, *before);
    SceneChanges changes;
    {
      const Turn turn(plugins().mutex);
      changes = editor_->update();
    }
    if (editor_->scene() != before && !former.shapes.empty()) former_.push_back(std::move(former));
    return nb::make_tuple(changes.made, changes.refitted, changes.has_new_structure);
  }

  /// Returns (array, names of channels, statistics). `camera` has the sensor if another scene has
  /// it; otherwise nullptr.
  nb::tuple render(nb::object integrator, Editor* camera, const std::string& sensor,
                   uint32_t samples, uint64_t seed, double seconds, double rel_mse, uint32_t lanes,
                   unsigned threads, nb::object progress, nb::object on_pass) {
    const Use use(*this);
    std::optional<Use> use_of_camera;
    if (camera) use_of_camera.emplace(*camera);
    RenderRequest request{
        scene_for(integrator), nullptr,           samples, seed, threads, seconds, rel_mse, lanes,
        std::move(progress),   std::move(on_pass)};
    const auto scene_of_sensor = camera ? camera->editor_->scene() : request.scene;
    Sensor& used = find_sensor(*scene_of_sensor, sensor);
    std::optional<BorrowedSensor> borrowed;
    if (camera) borrowed.emplace(used, *scene_of_sensor, *request.scene);
    request.sensor = &used;
    state_ = State::kRendering;
    if (camera) camera->state_ = State::kRendering;
    RenderStats stats;
    Image image = render_for_python(request, stats);
    nb::dict result;
    result["complete"] = stats.complete;
    result["samples"] = stats.samples;
    result["seed"] = seed;
    result["seconds"] = stats.render_seconds;
    result["threads"] = stats.threads;
    result["non_finite_samples"] = stats.non_finite_samples;
    result["relmse"] = stats.rel_mse >= 0 ? nb::cast(stats.rel_mse) : nb::object(nb::none());
    result["renders"] = stats.renders;
    result["variance_of_mean"] = stats.variance_of_mean;
    const std::vector<std::string> channels = image.channels;
    const auto names = cryptomatte_metadata(*request.scene, channels);
    if (!names.empty()) result["cryptomatte"] = names;
    return nb::make_tuple(picture_array(std::move(image)), channels, result);
  }

  nb::list inspect(nb::object integrator, const std::string& sensor, float x, float y,
                   uint64_t seed) {
    const Use use(*this);
    const auto scene = scene_for(integrator);
    const Sensor& seen_by = find_sensor(*scene, sensor);
    std::vector<Inspection> found;
    {
      const nb::gil_scoped_release release;
      RenderContext context({.seed = seed});
      const Integrator& used = scene->integrator();
      seen_by.film().prepare(used.layers(), used.channels());
      found = used.inspect(*scene, seen_by, context, Vec2(x, y));
    }
    nb::list all;
    for (const Inspection& one : found) all.append(as_dict(one));
    return all;
  }

 private:
  /// Use of the scene. Python's lock protects it; another mutex could deadlock, because a callback
  /// of the rendering thread can read it.
  enum class State { kFree, kUpdating, kRendering };

  /// Scene from before an update that surface points keep alive, and the paths of its shapes.
  struct FormerScene {
    std::weak_ptr<const Scene> scene;
    std::vector<std::string> shapes;
  };

  /// Keeps the scene from updates, for its lifetime. Several threads can read it. Throws Error
  /// during an update.
  class Reading {
   public:
    explicit Reading(Editor& editor) : editor_(editor) {
      editor.editor();
      ++editor.readers_;
    }
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    ~Reading() { --editor_.readers_; }

   private:
    Editor& editor_;
  };

  /// Marks the scene as used, for its lifetime. Throws Error if the scene is in use already.
  class Use {
   public:
    explicit Use(Editor& editor) : editor_(editor) {
      if (editor.state_ != State::kFree || editor.readers_ > 0) {
        throw Error("this scene is in use: it is being rendered, updated or queried");
      }
      editor.state_ = State::kUpdating;
    }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() { editor_.state_ = State::kFree; }

   private:
    Editor& editor_;
  };

  /// Returns the editor. Throws Error during an update.
  SceneEditor& editor() const {
    if (state_ == State::kUpdating) {
      throw Error("this scene is in use: another thread updates or inspects it");
    }
    return *editor_;
  }

  std::shared_ptr<const Scene> scene_for(nb::handle integrator) {
    if (integrator.is_none()) return editor_->scene();
    const ObjectDescription description = to_description(integrator);
    const Turn turn(plugins().mutex);
    return editor_->scene_with(description);
  }

  static Sensor& find_sensor(const Scene& scene, const std::string& wanted) {
    for (size_t i = 0; i < scene.sensors().size(); ++i) {
      Sensor& sensor = *scene.sensors()[i];
      if (sensor.id() == wanted || std::to_string(i) == wanted) return sensor;
    }
    throw Error(Location{scene.file(), 0, 0}, "there is no sensor '" + wanted + "'");
  }

  static nb::dict as_dict(const Inspection& one) {
    const auto triple = [](const Vec3& v) { return nb::make_tuple(v.x, v.y, v.z); };
    nb::dict result;
    result["kind"] = one.is_distant ? "distant" : "local";
    result["position"] = triple(one.position);
    result["normal"] = triple(one.normal);
    nb::list clusters, samples;
    for (const InspectedCluster& c : one.clusters) {
      nb::dict row;
      row["lo"] = triple(c.box.lo), row["hi"] = triple(c.box.hi), row["mean"] = triple(c.mean);
      row["points"] = c.points, row["light"] = c.light, row["brdf"] = c.brdf;
      row["geometric"] = c.geometric, row["probability"] = c.probability;
      row["samples"] = c.samples, row["hits"] = c.hits, row["visibility"] = c.visibility;
      clusters.append(row);
    }
    for (const InspectedSample& s : one.samples) {
      nb::dict row;
      row["position"] = triple(s.position), row["weight"] = s.weight, row["visible"] = s.visible;
      samples.append(row);
    }
    result["clusters"] = clusters;
    result["samples"] = samples;
    return result;
  }

  RenderStats stats_;
  std::unique_ptr<SceneEditor> editor_;
  State state_ = State::kFree;
  int readers_ = 0;
  std::vector<FormerScene> former_;
  std::weak_ptr<const Scene> measured_;  ///< scene of max_coordinate_
  float max_coordinate_ = 0;
};

}  // namespace
}  // namespace kinome::python

NB_MODULE(_kinome, m) {
  namespace nb = nanobind;
  using namespace nb::literals;
  using namespace kinome::python;
  nb::set_leak_warnings(false);
  nb::register_exception_translator(translate);
  m.def("set_up", [](nb::object error, const std::vector<std::string>& folders) {
    error_class() = std::move(error);
    plugins().folders = folders;
    kinome::set_log_level(kinome::LogLevel::kWarn);
  });
  m.def("set_log_level",
        [](int level) { kinome::set_log_level(static_cast<kinome::LogLevel>(level)); });
  m.attr("version") = KINOME_VERSION;
  m.def("plugins", &list_plugins);
  m.def("plugin_names", &plugin_names);
  m.def("measured_index", &measured_index_of);
  m.def("write_picture", &write_picture);
  m.def("encode_picture", &encode_picture);
  m.def("write_bytes", &write_bytes);
  m.def("denoise", &denoise, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
        nb::arg(), nb::arg());
  m.def("spawn_origins", &spawn_origins);
  m.def("shadow_rays", &shadow_rays);
  nb::class_<HeldScene>(m, "HeldScene");
  nb::class_<Editor>(m, "Editor")
      .def(nb::init<const std::string&, const std::map<std::string, std::string>&,
                    const std::vector<std::string>&, bool>())
      .def(nb::init<const std::string&, const std::string&,
                    const std::map<std::string, std::string>&, const std::vector<std::string>&,
                    bool>())
      .def(nb::init<nb::handle, const std::vector<std::string>&>())
      .def("parameters", &Editor::parameters)
      .def("get", &Editor::get)
      .def("set", &Editor::set)
      .def("set_all", &Editor::set_all)
      .def("unset", &Editor::unset)
      .def("revert", &Editor::revert)
      .def("objects", &Editor::objects)
      .def("plugin", &Editor::plugin)
      .def("textures", &Editor::textures)
      .def("save", &Editor::save)
      .def("sensors", &Editor::sensors)
      .def("shapes", &Editor::shapes)
      .def("emitters", &Editor::emitters)
      .def("hit_shapes", &Editor::hit_shapes)
      .def("environment", &Editor::environment)
      .def("parts", &Editor::parts)
      .def("bounds", &Editor::bounds)
      .def("max_coordinate", &Editor::max_coordinate)
      .def("relative_index", &Editor::relative_index)
      .def("filter", &Editor::filter)
      .def("intersect", Editor::query(&intersect_rays))
      .def("occluded", Editor::query(&occlude_rays))
      .def("sample_rays", Editor::query(&sample_rays))
      .def("shade", Editor::query(&shade_points), nb::arg(), nb::arg(), nb::arg().none(),
           nb::arg().none(), nb::arg().none(), nb::arg())
      .def("albedo", Editor::query(&albedo_of_points))
      .def("emission", Editor::query(&emission_of_points))
      .def("sample_emitters", Editor::query(&sample_emitters))
      .def("update", &Editor::update)
      .def("render", &Editor::render, "integrator"_a.none(), "camera"_a.none(), "sensor"_a,
           "samples"_a, "seed"_a, "seconds"_a, "rel_mse"_a, "lanes"_a, "threads"_a,
           "progress"_a.none(), "on_pass"_a.none())
      .def("inspect", &Editor::inspect, "integrator"_a.none(), "sensor"_a, "x"_a, "y"_a, "seed"_a);
}
