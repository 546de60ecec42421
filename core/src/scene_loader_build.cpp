#include "scene_loader_build.h"

#include <algorithm>
#include <optional>

#include "kinome/log.h"
#include "kinome/texture.h"
#include "plugin_check.h"
#include "property_types.h"
#include "scene_loader_convert.h"
#include "traceable.h"

namespace kinome::loader {
namespace {

/// Objects may be nested this deep, references included; far beyond any use, far below what the
/// stack holds.
constexpr size_t kDeepestObjects = 500;

std::optional<Category> category_of_tag(const std::string& tag) {
  for (int i = 0; i < kCategoryCount; ++i) {
    const auto category = static_cast<Category>(i);
    if (tag == to_string(category)) return category;
  }
  return std::nullopt;
}

/// Made only where something refers to them: their files may be large.
bool is_made_on_demand(const Node& node) {
  const auto category = category_of_tag(node.tag);
  return category == Category::kBsdf || category == Category::kTexture;
}

bool takes(const PluginDescriptor& plugin, Category category) {
  return std::any_of(plugin.parameters.begin(), plugin.parameters.end(), [&](const auto& row) {
    return row.type == ParameterType::kObject && row.category == category;
  });
}

bool has_object(const Properties& props, Category category) {
  return std::any_of(props.entries().begin(), props.entries().end(), [&](const auto& entry) {
    const auto* object = std::get_if<std::shared_ptr<Object>>(&entry.second.value);
    return object && category_of(**object) == category;
  });
}

/// Why a lamp gives no light, though nothing is wrong with its numbers; "": it does.
const char* why_dark(const Shape& shape) {
  constexpr float kLeastSize = 0x1p-22f;  // four units of rounding, at most, at a distance of 1
  if (!(shape.area() > 0)) return "this lamp has no area: it gives no light";
  const Aabb box = shape.bounds();
  const float distance = max_component(glm::max(glm::abs(box.lo), glm::abs(box.hi)));
  if (max_component(box.extent()) > kLeastSize * distance) return "";
  return "this lamp is so small, as far from the origin as it is, that rounding decides whether it "
         "gives any light";
}

}  // namespace

Builder::Builder(const Expansion& expansion, std::vector<std::string> base_folders,
                 PluginRegistry& registry)
    : expansion_(expansion), base_folders_(std::move(base_folders)), registry_(registry) {
  collect_ids(expansion.root);
}

void Builder::collect_ids(const Node& node) {
  const Attribute* id = node.find("id");
  if (id && node.tag != "ref") ids_[id->value] = &node;
  for (const Node& child : node.children) collect_ids(child);
}

const Node& Builder::target_of(const Node& ref) const {
  const Attribute& id = *ref.find("id");
  std::string target = id.value;
  // An alias names what stands above it, so that a chain of them ends.
  for (auto alias = expansion_.aliases.find(target); alias != expansion_.aliases.end();
       alias = expansion_.aliases.find(target)) {
    target = alias->second;
  }
  const auto found = ids_.find(target);
  if (found != ids_.end()) {
    if (under_way_.count(found->second)) {
      throw Error(id.where, "'" + id.value + "' refers to an object that it is part of");
    }
    return *found->second;
  }
  std::vector<std::string> known;
  for (const auto& entry : ids_) known.push_back(entry.first);
  for (const auto& entry : expansion_.aliases) known.push_back(entry.first);
  throw Error(id.where, "nothing has the id '" + id.value + "'" +
                            did_you_mean(nearest_name(id.value, known)));
}

std::shared_ptr<Object> Builder::object(const Node& node) {
  if (const auto known = objects_.find(&node); known != objects_.end()) return known->second;
  const auto category = category_of_tag(node.tag);
  if (!category) {
    throw Error(node.where, node.tag == "scene" ? "a <scene> is not an object of its own"
                                                : quoted_tag(node) + " is not supported");
  }
  if (under_way_.size() >= kDeepestObjects)
    throw Error(node.where, "objects are nested too deeply");
  under_way_.insert(&node);
  Properties props = start_properties(node, *category);
  int unnamed = 0;
  for (const Node& child : node.children) {
    add_child(child, props, unnamed, [this](const Node& part) { return object(part); });
  }
  auto object = create(props, node.find("type")->where);
  under_way_.erase(&node);
  objects_[&node] = object;
  return object;
}

Properties Builder::start_properties(const Node& node, Category category) {
  Properties props(category, node.value("type"), node.where);
  props.set_id(node.value("id"));
  props.set_search_paths(folders(node));
  registry_.find(category, props.plugin_name(), node.find("type")->where);
  return props;
}

void Builder::add_child(const Node& child, Properties& props, int& unnamed, const Maker& make) {
  const bool is_object = child.tag == "ref" || child.find("type");
  const std::string name =
      child.find("name") ? child.value("name") : "_arg_" + std::to_string(unnamed++);
  if (is_object) {
    props.set(name, make(child.tag == "ref" ? target_of(child) : child), child.where);
    return;
  }
  const PluginDescriptor& plugin = registry_.find(props.category(), props.plugin_name());
  props.set(name, convert(child, find_row(plugin, name), *folders(child)), child.where);
}

/// All that can be said of a BSDF or texture without making it.
void Builder::check(const Node& node) {
  if (!checked_.insert(&node).second) return;
  if (under_way_.size() >= kDeepestObjects)
    throw Error(node.where, "objects are nested too deeply");
  under_way_.insert(&node);
  Properties props = start_properties(node, *category_of_tag(node.tag));
  int unnamed = 0;
  for (const Node& child : node.children) {
    if (child.tag == "ref") named_by_unused_.insert(&target_of(child));
    add_child(child, props, unnamed, [this](const Node& part) { return stand_in(part); });
  }
  const PluginDescriptor& plugin = registry_.find(props.category(), props.plugin_name());
  check_parameters(props, plugin);
  props.set_table(plugin.parameters);
  for (const Parameter& row : plugin.parameters) {
    // Checks a colour's range.
    if (row.type == ParameterType::kReflectanceTexture) props.texture(row.name);
  }
  under_way_.erase(&node);
}

/// An object of the node's category, for what is checked and not made.
std::shared_ptr<Object> Builder::stand_in(const Node& node) {
  if (!is_made_on_demand(node)) return object(node);
  check(node);
  if (category_of_tag(node.tag) == Category::kBsdf) return make_black_bsdf();
  return make_uniform_texture(Rgb(0.f));
}

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

void Builder::warn_of_dark_lamp(const Shape& shape, const Location& where) {
  constexpr int kMostTold = 5;
  const std::string why = why_dark(shape);
  if (why.empty() || ++dark_lamps_ > kMostTold + 1) return;
  const bool is_last = dark_lamps_ > kMostTold;
  log_warn(Error(where, is_last ? why + "; what else is so is not told" : why).what());
}

std::shared_ptr<Object> Builder::create(Properties& props, const Location& type_where) {
  const PluginDescriptor& plugin =
      registry_.find(props.category(), props.plugin_name(), type_where);
  const std::string name = std::string(to_string(props.category())) + "/" + props.plugin_name();
  if (std::find(plugins_.begin(), plugins_.end(), name) == plugins_.end()) plugins_.push_back(name);
  add_default_children(props, plugin);
  auto object = registry_.create(props);
  if (props.category() != Category::kShape) return object;

  auto& shape = dynamic_cast<Shape&>(*object);
  if (shape.emitter()) warn_of_dark_lamp(shape, props.where());
  if (shape.bsdf_pointer()) return object;
  if (shape.emitter()) {
    shape.set_bsdf(make_black_bsdf());
  } else {
    Properties diffuse(Category::kBsdf, "diffuse", props.where());
    shape.set_bsdf(std::dynamic_pointer_cast<Bsdf>(create(diffuse, props.where())));
  }
  return object;
}

/// What Mitsuba gives to a sensor or film that lacks it, as if the scene said so.
void Builder::add_default_children(Properties& props, const PluginDescriptor& plugin) {
  struct Default {
    Category parent;
    Category child;
    const char* plugin;
  };
  constexpr Default kDefaults[] = {
      {Category::kSensor, Category::kFilm, "hdrfilm"},
      {Category::kSensor, Category::kSampler, "independent"},
      {Category::kFilm, Category::kReconstructionFilter, "gaussian"},
  };
  for (const Default& missing : kDefaults) {
    if (missing.parent != props.category() || !takes(plugin, missing.child) ||
        has_object(props, missing.child)) {
      continue;
    }
    Properties child(missing.child, missing.plugin, props.where());
    props.set("_default_" + std::string(to_string(missing.child)), create(child, props.where()),
              props.where());
  }
}

std::shared_ptr<const std::vector<std::string>> Builder::folders(const Node& node) {
  auto& list = folder_lists_[node.folders.get()];
  if (!list) {
    std::vector<std::string> all;
    if (node.folders) all = *node.folders;
    all.insert(all.end(), expansion_.paths.begin(), expansion_.paths.end());
    all.insert(all.end(), base_folders_.begin(), base_folders_.end());
    list = std::make_shared<const std::vector<std::string>>(std::move(all));
  }
  return list;
}

Scene::Contents Builder::scene(const Node& root) {
  Scene::Contents contents;
  std::map<std::string, Location> names;
  for (const Node& child : root.children) {
    const bool is_object = child.tag == "ref" || child.find("type");
    if (!is_object) {
      throw Error(child.where, "<scene> leaves unreferenced: '" + child.value("name") + "'");
    }
    if (const Attribute* name = child.find("name")) {
      const auto [other, is_new] = names.emplace(name->value, child.where);
      if (!is_new) {
        throw Error(child.where, "'" + name->value + "' is given twice (first at " +
                                     to_string(other->second) + ")");
      }
    }
    if (is_made_on_demand(child)) continue;
    add_to_scene(child, object(child.tag == "ref" ? target_of(child) : child), contents);
  }
  check_unused(root);
  complete_scene(root.where, contents);
  return contents;
}

/// BSDFs, textures and the like are there to be referred to; alone they mean nothing.
void Builder::add_to_scene(const Node& child, const std::shared_ptr<Object>& object,
                           Scene::Contents& contents) {
  // References may name one object several times.
  const auto add = [this](auto& list, const auto& item) {
    if (in_scene_.insert(item.get()).second) list.push_back(item);
  };
  if (auto shape = std::dynamic_pointer_cast<Shape>(object)) {
    // Here, where its place is known; the scene would have but its number.
    const std::string fault = why_untraceable(shape->bounds());
    if (!fault.empty()) {
      const Node& node = child.tag == "ref" ? target_of(child) : child;
      throw Error(node.where, "this " + node.value("type") + " " + fault);
    }
    add(contents.shapes, shape);
  } else if (auto sensor = std::dynamic_pointer_cast<Sensor>(object)) {
    add(contents.sensors, sensor);
  } else if (auto emitter = std::dynamic_pointer_cast<Emitter>(object)) {
    const bool second =
        emitter->is_environment() &&
        std::any_of(contents.emitters.begin(), contents.emitters.end(),
                    [&](const auto& other) { return other != emitter && other->is_environment(); });
    if (second) throw Error(child.where, "a scene has at most one environment emitter");
    if (emitter->is_surface()) {
      throw Error(child.where, "an '" + child.value("type") +
                                   "' emitter shines from a surface: put it into a <shape>");
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
    log_info("the scene has no integrator: using 'direct'");
    Properties props(Category::kIntegrator, "direct", where);
    contents.integrator = std::dynamic_pointer_cast<Integrator>(create(props, where));
  }
  for (const auto& [emitter, place] : top_emitters_) {
    for (const auto& child : emitter->children()) {
      if (child->is_surface() && !child->shape()) {
        throw Error(place,
                    "an emitter in it shines from a surface, and is part of no shape: put it "
                    "into a <shape>, and refer to it here");
      }
    }
  }
  complete_indirect_light(where, contents);
  if (contents.sensors.empty()) {
    log_info("the scene has no sensor: using a perspective camera that sees all shapes");
    contents.sensors.push_back(std::dynamic_pointer_cast<Sensor>(default_sensor(where, contents)));
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
                   "('clustered' and 'groundtruth' ask with a max_depth of 3 or more, or -1)")
                 .what());
  }
  if (!plugin || has_indirect) return;
  log_debug("the integrator brings a '" + std::string(plugin) +
            "' along, for light after a bounce");
  // No line of the file is to blame for what it does.
  Properties props(Category::kEmitter, plugin, Location{where.file});
  contents.emitters.push_back(std::dynamic_pointer_cast<Emitter>(create(props, where)));
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
