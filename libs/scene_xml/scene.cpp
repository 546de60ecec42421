// Builds a scene's contents from its nodes, and adds defaults for missing objects.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/light_groups.h"
#include "kinome/log.h"
#include "scene/bounces.h"
#include "scene/traceable.h"
#include "scene_xml/objects/build.h"
#include "scene_xml/values/convert.h"

namespace kinome::loader {
namespace {

constexpr const char* kSecondEnvironment = "a scene has at most one environment emitter";

}  // namespace

/// Checks objects that weren't made because nothing uses them, and lists them as skipped. Must be
/// called after all used objects were made.
void Builder::check_unused(const Node& root) {
  const auto is_unused = [this](const Node& node) {
    return is_made_on_demand(node) && !objects_.count(&node);
  };
  for (const Node& child : root.children) {
    if (is_unused(child)) check(child);
  }
  for (const Node& child : root.children) {
    if (!is_unused(child)) continue;
    const std::string id = child.value("id");
    skipped_.push_back({child.tag + (id.empty() ? " without id" : " '" + id + "'"),
                        referenced_by_unused_.count(&child) ? "only unused objects refer to it"
                                                            : "nothing refers to it"});
  }
}

/// Resets the state that belongs to a single scene, because a builder may make several.
void Builder::forget_scene() {
  dark_emitters_ = 0;
  checked_.clear();
  referenced_by_unused_.clear();
  in_scene_.clear();
  top_emitters_.clear();
  surface_emitters_.clear();
  parameters_.clear();
  skipped_.clear();
  ahead_.reset();
  begun_.clear();
}

Scene::Contents Builder::scene(const Node& root) {
  forget_scene();
  begin_readers(root);
  Scene::Contents contents;
  if (integrator_) {
    contents.integrator = std::dynamic_pointer_cast<Integrator>(object(*integrator_));
  }
  std::map<std::string, Location> names;
  for (const Node& child : root.children) {
    if (!is_object(child)) {
      if (child.is_broken) continue;
      faults_.attempt([&] {
        set_parameter(child.value("name"), convert(child, nullptr, *folders(child)), child.where,
                      contents);
      });
      continue;
    }
    if (const Attribute* name = child.find("name")) {
      const auto [other, is_new] = names.emplace(name->value, child.where);
      if (!is_new) {
        faults_.add(child.where, "'" + name->value + "' is given twice (first at " +
                                     to_string(other->second) + ")");
      }
    }
    if (is_made_on_demand(child)) continue;
    const Node* const target = child.tag == "ref" ? target_of(child) : &child;
    if (!target || (integrator_ && target->tag == "integrator")) continue;
    if (const auto made = object(*target)) {
      faults_.attempt([&] { add_to_scene(child, *target, made, contents); });
    }
  }
  for (const auto& [name, value, where] : root.overrides) {
    faults_.attempt([&, &name = name, &value = value, &where = where] {
      set_parameter(name, value, where, contents);
    });
  }
  ahead_.reset();
  begun_.clear();
  check_unused(root);
  if (faults_.empty()) faults_.attempt([&] { complete_scene(root.where, contents); });
  return contents;
}

/// Sets a parameter of the scene itself. Mitsuba's scenes have parameters for Embree, and for its
/// own acceleration structures, which are ignored.
void Builder::set_parameter(const std::string& name, const Properties::Value& value,
                            const Location& where, Scene::Contents& contents) {
  const bool is_ignored = name == "allow_thread_reordering" || name.rfind("kd_", 0) == 0;
  const bool is_robust = name == "embree_use_robust_intersections";
  if (!is_ignored && !is_robust) {
    throw Error(where, "<scene> has unused parameters: '" + name + "'");
  }
  if (const auto [other, is_new] = parameters_.emplace(name, where); !is_new) {
    throw Error(where, "'" + name + "' is given twice (first at " + to_string(other->second) + ")");
  }
  if (is_ignored) {
    log_info(Error(where, "'" + name + "' is ignored: it has no effect in kinome").what());
  } else if (const bool* const robust = std::get_if<bool>(&value)) {
    contents.watertight = *robust;
  } else {
    throw Error(where, "'" + name + "' must be a boolean");
  }
}

/// Adds an object to the scene. BSDFs, textures and the like have no effect by themselves. `target`
/// is `child`, or the node that `child` refers to.
void Builder::add_to_scene(const Node& child, const Node& target,
                           const std::shared_ptr<Object>& object, Scene::Contents& contents) {
  // References may name one object several times.
  const auto add = [this](auto& list, const auto& item) {
    if (in_scene_.insert(item.get()).second) list.push_back(item);
  };
  if (std::dynamic_pointer_cast<ShapeGroup>(object)) return;  // its instances show it
  if (auto shape = std::dynamic_pointer_cast<Shape>(object)) {
    // Checked here, where the location in the file is known.
    const bool is_empty = has_no_surface(*shape);
    if (is_empty && !shape->mesh()) {  // mesh readers warn by themselves
      log_warn(
          Error(target.where, "this " + target.value("type") + " has no surface and is invisible")
              .what());
    }
    const std::string fault = is_empty ? "" : why_untraceable(shape->bounds());
    if (!fault.empty()) {
      throw Error(target.where, "this " + target.value("type") + " " + fault);
    }
    add(contents.shapes, shape);
    add_instances(shape, target.where);
    if (const auto nested = shape->sensor_pointer()) add(contents.sensors, nested);
    for (const auto& part : shape->parts()) {
      if (const auto nested = part->sensor_pointer()) add(contents.sensors, nested);
    }
  } else if (auto sensor = std::dynamic_pointer_cast<Sensor>(object)) {
    if (sensor->is_surface()) {
      throw Error(target.where, "this sensor measures at a surface: put it into a <shape>");
    }
    add(contents.sensors, sensor);
  } else if (auto emitter = std::dynamic_pointer_cast<Emitter>(object)) {
    const bool is_second =
        emitter->is_environment() &&
        std::any_of(contents.emitters.begin(), contents.emitters.end(),
                    [&](const auto& other) { return other != emitter && other->is_environment(); });
    if (is_second) throw Error(child.where, kSecondEnvironment);
    if (emitter->is_surface()) {  // belongs to the shape that refers to it, if there is one
      surface_emitters_.emplace_back(
          emitter, Error(target.where, "this '" + target.value("type") +
                                           "' emitter isn't part of a shape and emits no light"));
      return;
    }
    add(contents.emitters, emitter);
    top_emitters_.emplace_back(emitter, child.where);
  } else if (auto integrator = std::dynamic_pointer_cast<Integrator>(object)) {
    if (contents.integrator && contents.integrator != integrator) {
      throw Error(child.where, "a scene has at most one integrator");
    }
    contents.integrator = integrator;
  }
}

void Builder::complete_scene(const Location& where, Scene::Contents& contents) {
  if (!contents.integrator) {
    log_warn(Error(where, "the scene has no integrator: using 'path'").what());
    contents.integrator =
        std::dynamic_pointer_cast<Integrator>(default_object(Category::kIntegrator, "path", where));
  }
  for (const auto& [emitter, where_used] : top_emitters_) {
    for (const auto& child : emitter->children()) {
      if (child->is_surface() && !child->shape()) {
        faults_.add(where_used,
                    "a nested emitter needs a surface, but isn't part of a shape: put it into a "
                    "<shape>, and refer to it here");
      }
    }
  }
  check_top_emitters();
  for (const auto& [emitter, fault] : surface_emitters_) {
    if (!emitter->shape()) log_warn(fault.what());
  }
  if (!faults_.empty()) return;
  complete_indirect_light(where, contents);
  if (contents.sensors.empty()) {
    log_info("the scene has no sensor: using a perspective camera that sees all shapes");
    contents.sensors.push_back(std::dynamic_pointer_cast<Sensor>(default_sensor(where, contents)));
  }
  check_instances(contents);
  warn_of_ignored_media(where, contents);
  set_emitters_of_integrator(contents);
  if (denoising_) contents.integrator = with_guides(contents.integrator, where);
}

/// Reports emitters that can't be in a scene together. Nested emitters are part of the scene.
void Builder::check_top_emitters() {
  const Emitter* environment = nullptr;
  for (size_t i = 0; i < top_emitters_.size(); ++i) {
    const auto& [emitter, where] = top_emitters_[i];
    std::vector<std::shared_ptr<Emitter>> all = emitter->children();
    all.push_back(emitter);
    for (const auto& one : all) {
      if (!one->is_environment() || one.get() == environment) continue;
      if (environment) faults_.add(where, kSecondEnvironment);
      environment = one.get();
    }
    for (size_t k = 0; k < i && emitter->is_indirect(); ++k) {
      const Emitter& other = *top_emitters_[k].first;
      if (&other == emitter.get() || !other.is_indirect()) continue;
      if (have_same_bounce(*emitter, other)) faults_.add(where, kSameBounce);
    }
  }
}

/// Warns if the scene has media that its integrator doesn't trace.
void Builder::warn_of_ignored_media(const Location& where, const Scene::Contents& contents) {
  if (contents.integrator->traces_media()) return;
  const auto has_media = [](const Shape& shape) { return shape.separates_media(); };
  const bool is_any =
      std::ranges::any_of(contents.sensors, [](const auto& sensor) { return sensor->medium(); }) ||
      std::ranges::any_of(contents.shapes, [&](const auto& shape) {
        const auto parts = shape->parts();
        return has_media(*shape) ||
               std::ranges::any_of(parts, [&](const auto& part) { return has_media(*part); });
      });
  if (!is_any) return;
  log_warn(Error(where, "the scene's media are ignored: the integrator doesn't support media "
                        "(volpath does)")
               .what());
}

/// Records `shape` if it is an instance, or the instances among its parts.
void Builder::add_instances(const std::shared_ptr<Shape>& shape, const Location& where) {
  if (const auto instance = std::dynamic_pointer_cast<const ShapeInstance>(shape)) {
    if (!is_invertible_by_tracer(instance->to_world())) {
      throw Error(where,
                  "the to_world of this instance scales by too much for the ray tracer: "
                  "scales must be between 1e-12 and 1e12");
    }
    instances_.emplace_back(instance, where);
    return;
  }
  for (const auto& part : shape->parts()) add_instances(part, where);
}

/// Throws Error unless rays from the whole scene stay within the ray tracer's range in each
/// instance's space. Rays of distant emitters start outside of the scene, up to its diameter away.
void Builder::check_instances(const Scene::Contents& contents) const {
  if (instances_.empty()) return;
  float reach = 1;  // minimum: the length of directions
  const auto include = [&](const Vec3& p) {
    if (is_finite(p)) reach = std::max(reach, max_component(glm::abs(p)));
  };
  for (const auto& shape : contents.shapes) {
    include(shape->bounds().lo);
    include(shape->bounds().hi);
  }
  for (const auto& sensor : contents.sensors) {
    const Rect& crop = sensor->film().crop();
    include(sensor->sample_ray(0.5f * Vec2(crop.x0 + crop.x1, crop.y0 + crop.y1), Vec2(0.5f)).o);
  }
  for (const auto& [instance, where] : instances_) {
    if (max_ray_coordinate(instance->to_world()) >= 2 * reach) continue;
    throw Error(where, fmt::format("this instance is scaled down too far: rays from {:.3g} units "
                                   "away are beyond the ray tracer's range in its space",
                                   reach));
  }
}

/// Adds an indirect emitter if the integrator needs one, and warns if it doesn't use the scene's.
void Builder::complete_indirect_light(const Location& where, Scene::Contents& contents) {
  const char* const plugin = contents.integrator->default_indirect_emitter();
  bool has_indirect = false;
  for (const auto& [emitter, where_used] : top_emitters_) {
    if (!emitter->is_indirect()) continue;
    has_indirect = true;
    if (plugin) continue;
    log_warn(Error(where_used,
                   "this emitter is ignored: it represents one bounce of other emitters' light, "
                   "which the scene's integrator doesn't use with its parameters (max_depth must "
                   "be 3 or more, or -1)")
                 .what());
  }
  if (!plugin || has_indirect) return;
  log_debug("the integrator adds a '" + std::string(plugin) + "' emitter for light after a bounce");
  // Without a line, because the emitter isn't in the file.
  contents.emitters.push_back(std::dynamic_pointer_cast<Emitter>(
      default_object(Category::kEmitter, plugin, Location{where.file, 0, 0})));
}

/// Returns the object of a plugin without parameters, which is made once.
std::shared_ptr<Object> Builder::default_object(Category category, const char* plugin,
                                                const Location& where) {
  std::shared_ptr<Object>& object = defaults_[plugin];
  if (!object) {
    Properties props(category, plugin, where);
    object = create(props, where);
  }
  return object;
}

/// Returns Mitsuba's default sensor: in front of the scene (on its -z side), with a field of view
/// of 45 degrees.
std::shared_ptr<Object> Builder::default_sensor(const Location& where,
                                                const Scene::Contents& contents) {
  Properties props(Category::kSensor, "perspective", where);
  constexpr double kFov = 45;
  props.set("fov", kFov, where);
  Aabb bounds;
  for (const auto& shape : contents.shapes) bounds.expand(shape->bounds());
  if (!bounds.empty()) {
    const double size = std::max(max_component(bounds.extent()), 1e-6f);
    const double distance = size / (2 * std::tan(glm::radians(kFov) / 2));
    props.set("near_clip", distance / 100, where);
    props.set("far_clip", size * 5 + distance, where);
    Mat4 to_world(1.f);
    to_world[3] = glm::vec4(bounds.centre().x, bounds.centre().y,
                            bounds.lo.z - static_cast<float>(distance), 1.f);
    props.set("to_world", Transform(to_world), where);
  }
  return create(props, where);
}

}  // namespace kinome::loader
