// From a scene's nodes to its contents, with what it lacks made up for.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/log.h"
#include "loader/build.h"
#include "loader/convert.h"
#include "scene/traceable.h"

namespace kinome::loader {

/// After all that is used was made: what is left serves nothing.
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
                        named_by_unused_.count(&child) ? "only what is unused refers to it"
                                                       : "nothing refers to it"});
  }
}

/// What is of one scene alone, where several are made.
void Builder::forget_scene() {
  dark_lamps_ = 0;
  checked_.clear();
  named_by_unused_.clear();
  in_scene_.clear();
  top_emitters_.clear();
  surface_emitters_.clear();
  parameters_.clear();
  skipped_.clear();
}

Scene::Contents Builder::scene(const Node& root) {
  forget_scene();
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
  for (const auto& [name, value, where] : root.given) {
    faults_.attempt([&, &name = name, &value = value, &where = where] {
      set_parameter(name, value, where, contents);
    });
  }
  check_unused(root);
  if (faults_.empty()) faults_.attempt([&] { complete_scene(root.where, contents); });
  return contents;
}

/// The parameters that Mitsuba's scenes have: of ray tracing in Embree, and of accelerators that
/// aren't used here.
void Builder::set_parameter(const std::string& name, const Properties::Value& value,
                            const Location& where, Scene::Contents& contents) {
  const bool is_of_others = name == "allow_thread_reordering" || name.rfind("kd_", 0) == 0;
  const bool is_robust = name == "embree_use_robust_intersections";
  if (!is_of_others && !is_robust) {
    throw Error(where, "<scene> has unused parameters: '" + name + "'");
  }
  if (const auto [other, is_new] = parameters_.emplace(name, where); !is_new) {
    throw Error(where, "'" + name + "' is given twice (first at " + to_string(other->second) + ")");
  }
  if (is_of_others) {
    log_info(Error(where, "'" + name + "' means nothing here, and is ignored").what());
  } else if (const bool* const robust = std::get_if<bool>(&value)) {
    contents.watertight = *robust;
  } else {
    throw Error(where, "'" + name + "' must be a boolean");
  }
}

/// BSDFs, textures and the like are there to be referred to; alone they mean nothing. `target`:
/// what the child is, or refers to.
void Builder::add_to_scene(const Node& child, const Node& target,
                           const std::shared_ptr<Object>& object, Scene::Contents& contents) {
  // References may name one object several times.
  const auto add = [this](auto& list, const auto& item) {
    if (in_scene_.insert(item.get()).second) list.push_back(item);
  };
  if (std::dynamic_pointer_cast<ShapeGroup>(object)) return;  // its instances show it
  if (auto shape = std::dynamic_pointer_cast<Shape>(object)) {
    // Here, where its place is known; the scene would have but its number.
    const bool is_empty = has_no_surface(*shape);
    if (is_empty && !shape->mesh()) {  // readers of meshes have warned of those
      log_warn(Error(target.where,
                     "this " + target.value("type") + " has no surface: nothing of it is visible")
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
    const bool second =
        emitter->is_environment() &&
        std::any_of(contents.emitters.begin(), contents.emitters.end(),
                    [&](const auto& other) { return other != emitter && other->is_environment(); });
    if (second) throw Error(child.where, "a scene has at most one environment emitter");
    if (emitter->is_surface()) {  // is part of the shape that refers to it, if there is one
      surface_emitters_.emplace_back(
          emitter, Error(target.where, "this '" + target.value("type") +
                                           "' emitter is part of no shape, and gives no light"));
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
    contents.integrator = std::dynamic_pointer_cast<Integrator>(
        default_object(Category::kIntegrator, "path", where));
  }
  for (const auto& [emitter, place] : top_emitters_) {
    for (const auto& child : emitter->children()) {
      if (child->is_surface() && !child->shape()) {
        faults_.add(place,
                    "an emitter in it shines from a surface, and is part of no shape: put it "
                    "into a <shape>, and refer to it here");
      }
    }
  }
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
}

/// Remembers `shape` if it is an instance, or the instances among its parts.
void Builder::add_instances(const std::shared_ptr<Shape>& shape, const Location& where) {
  if (const auto instance = std::dynamic_pointer_cast<const ShapeInstance>(shape)) {
    if (!is_invertible_by_tracer(instance->to_world())) {
      throw Error(where, "the to_world of this instance scales too far up or down for the ray "
                         "tracer: scales between 1e-12 and 1e12 are possible");
    }
    instances_.emplace_back(instance, where);
    return;
  }
  for (const auto& part : shape->parts()) add_instances(part, where);
}

/// In an instance's space, rays from all of the scene must stay within the ray tracer's range. Rays
/// of distant light start outside of the scene, up to its diameter away.
void Builder::check_instances(const Scene::Contents& contents) const {
  if (instances_.empty()) return;
  float reach = 1;  // of directions, at least
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
  for (const auto& [instance, place] : instances_) {
    if (farthest_ray(instance->to_world()) >= 2 * reach) continue;
    throw Error(place, fmt::format("this instance is scaled down so far that rays from {:.3g} units "
                                   "away are beyond the ray tracer's range in its space",
                                   reach));
  }
}

/// An indirect emitter where the integrator wants one; a warning where it has no use for one.
void Builder::complete_indirect_light(const Location& where, Scene::Contents& contents) {
  const char* const plugin = contents.integrator->default_indirect_emitter();
  bool has_indirect = false;
  for (const auto& [emitter, place] : top_emitters_) {
    if (!emitter->is_indirect()) continue;
    has_indirect = true;
    if (plugin) continue;
    log_warn(Error(place,
                   "this emitter offers the bounce of others, which the scene's integrator, with "
                   "the parameters that it has, doesn't ask for: their bounce is not taken from it "
                   "(one that makes use of them asks where its max_depth is 3 or more, or -1)")
                 .what());
  }
  if (!plugin || has_indirect) return;
  log_debug("the integrator brings a '" + std::string(plugin) +
            "' along, for light after a bounce");
  // No line of the file is to blame for what it does.
  contents.emitters.push_back(std::dynamic_pointer_cast<Emitter>(
      default_object(Category::kEmitter, plugin, Location{where.file, 0, 0})));
}

/// Made once, and without parameters.
std::shared_ptr<Object> Builder::default_object(Category category, const char* plugin,
                                                const Location& where) {
  std::shared_ptr<Object>& object = defaults_[plugin];
  if (!object) {
    Properties props(category, plugin, where);
    object = create(props, where);
  }
  return object;
}

/// Mitsuba's: in front of the scene (on its -z side), 45 degrees.
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
