#include "loader/build.h"

#include <algorithm>

#include "kinome/log.h"
#include "kinome/texture.h"
#include "loader/convert.h"
#include "plugin/property_types.h"

namespace kinome::loader {
namespace {

/// Objects may be nested this deep, references included; far beyond any use, far below what the
/// stack holds.
constexpr size_t kDeepestObjects = 500;

/// Of a texture that has a mistake: within all bounds.
constexpr float kStandIn = 0.5f;

/// Whether an object of this plugin can be made without what is lost, so that other mistakes in it
/// are found: what it gets by default, or does without, leads to no others.
bool can_do_without(const Lost& lost, const PluginDescriptor& plugin) {
  constexpr Category kOptional[] = {Category::kEmitter, Category::kFilm, Category::kSampler,
                                    Category::kReconstructionFilter};
  const auto is_needed = [&](Category category) {
    return std::find(std::begin(kOptional), std::end(kOptional), category) == std::end(kOptional) ||
           std::any_of(plugin.parameters.begin(), plugin.parameters.end(), [&](const auto& row) {
             return row.type == ParameterType::kObject && row.category == category && row.required;
           });
  };
  return lost.names.empty() && !lost.anything &&
         std::none_of(lost.categories.begin(), lost.categories.end(), is_needed);
}

/// What Mitsuba's plugins of a category have for how they work, and not for what they show.
bool is_of_mitsubas_working(Category category, const std::string& name) {
  constexpr std::pair<Category, const char*> kAll[] = {
      {Category::kEmitter, "sampling_weight"},
      {Category::kIntegrator, "block_size"},
      {Category::kIntegrator, "samples_per_pass"},
      {Category::kIntegrator, "timeout"},
  };
  return std::any_of(std::begin(kAll), std::end(kAll), [&](const auto& one) {
    return one.first == category && name == one.second;
  });
}

bool takes(const PluginDescriptor& plugin, Category category) {
  return std::any_of(plugin.parameters.begin(), plugin.parameters.end(), [&](const auto& row) {
    return row.type == ParameterType::kObject && row.category == category;
  });
}

/// The parameter that a texture of any name, or none, is meant for.
std::optional<std::string> row_of_any_texture(const PluginDescriptor& plugin) {
  for (const Parameter& row : plugin.parameters) {
    if (row.type == ParameterType::kObject && row.category == Category::kTexture) return row.name;
  }
  return std::nullopt;
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

/// Of the attributes that textures of the shape read.
void check_attributes(const Shape& shape, const Location& where) {
  for (const std::string& name : shape.wanted_attributes()) {
    const auto found = shape.attribute(name);
    const std::string reads = "a texture of this shape reads the attribute '" + name + "', which ";
    if (!found) throw Error(where, reads + "the shape doesn't have");
    const uint32_t size = found->attribute->size;
    if (size != 1 && size != 3) {
      throw Error(where, reads + "has " + std::to_string(size) + " numbers, expected 1 or 3");
    }
  }
}

/// Of a texture that a light without a surface has.
void check_no_attribute(const Object& object, const Location& where) {
  for (const auto& part : object.nested()) {
    const auto* const texture = dynamic_cast<const Texture*>(part.get());
    if (texture && !texture->attribute().empty()) {
      throw Error(where, "this emitter is no surface of a mesh, whose attribute '" +
                             texture->attribute() + "' its texture could read");
    }
  }
}

}  // namespace

std::optional<Category> category_of_tag(const std::string& tag) {
  for (int i = 0; i < kCategoryCount; ++i) {
    const auto category = static_cast<Category>(i);
    if (tag == to_string(category)) return category;
  }
  return std::nullopt;
}

bool is_made_on_demand(const Node& node) {
  const auto category = category_of_tag(node.tag);
  return category == Category::kBsdf || category == Category::kTexture;
}

bool is_object(const Node& node) {
  const TagKind kind = kind_of(node);
  return kind == TagKind::kObject || kind == TagKind::kRef || kind == TagKind::kInclude;
}

Builder::Builder(const Expansion& expansion, std::vector<std::string> base_folders,
                 PluginRegistry& registry, Faults& faults)
    : expansion_(expansion),
      base_folders_(std::move(base_folders)),
      registry_(registry),
      faults_(faults) {
  collect_ids(expansion.root);
}

void Builder::collect_ids(const Node& node) {
  const Attribute* id = node.find("id");
  if (id && node.tag != "ref") ids_.emplace(id->value, &node);
  for (const Node& child : node.children) collect_ids(child);
}

/// An alias names what stands above it, so that a chain of them ends.
std::string Builder::unaliased(std::string id) const {
  for (auto alias = expansion_.aliases.find(id); alias != expansion_.aliases.end();
       alias = expansion_.aliases.find(id)) {
    id = alias->second;
  }
  return id;
}

const Node* Builder::target_of(const Node& ref) {
  if (ref.is_broken) return nullptr;
  const Attribute& id = *ref.find("id");
  const std::string target = unaliased(id.value);
  const auto found = ids_.find(target);
  if (found != ids_.end()) {
    if (!under_way_.count(found->second)) return found->second;
    faults_.add(id.where, "'" + id.value + "' refers to an object that it is part of");
    return nullptr;
  }
  if (expansion_.has_unknown_ids || expansion_.lost_ids.count(target)) return nullptr;
  std::vector<std::string> known;
  for (const auto& entry : ids_) known.push_back(entry.first);
  for (const auto& entry : expansion_.aliases) known.push_back(entry.first);
  faults_.add(id.where, "nothing has the id '" + id.value + "'" +
                            did_you_mean(faults_.nearest(id.value, known)));
  return nullptr;
}

/// A node is under way while what it is made of is made.
class Builder::UnderWay {
 public:
  UnderWay(Builder& builder, const Node& node) : builder_(builder), node_(node) {
    builder_.under_way_.insert(&node_);
  }
  ~UnderWay() { builder_.under_way_.erase(&node_); }
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;
  bool is_too_deep() const {
    if (builder_.under_way_.size() <= kDeepestObjects) return false;
    builder_.faults_.add(node_.where, "objects are nested too deeply");
    return true;
  }

 private:
  Builder& builder_;
  const Node& node_;
};

std::shared_ptr<Object> Builder::object(const Node& node) {
  if (const auto known = objects_.find(&node); known != objects_.end()) return known->second;
  const UnderWay under_way(*this, node);
  auto object = under_way.is_too_deep() ? nullptr : make(node);
  objects_[&node] = object;
  return object;
}

std::shared_ptr<Object> Builder::make(const Node& node) {
  const auto maker = [this](const Node& part) { return object(part); };
  const PluginDescriptor* const plugin = find_plugin(node);
  if (!plugin) {
    if (!is_missing(node, registry_)) look_at_parts(node, maker);
    return nullptr;
  }
  Parts parts = read_parts(node, *plugin, maker);
  std::shared_ptr<Object> made;
  if (can_do_without(parts.lost, *plugin)) {
    faults_.attempt([&] { made = create(parts.props, node.find("type")->where); });
  } else {
    for (const Error& fault : check_parameters(parts.props, *plugin, parts.lost)) {
      faults_.add(fault);
    }
  }
  return made;
}

/// nullptr: the node is no object, or of no plugin, or has other mistakes; they are told.
const PluginDescriptor* Builder::find_plugin(const Node& node) {
  if (is_missing(node, registry_)) {
    faults_.add(node.find("type")->where,
                node.tag + " '" + node.value("type") +
                    "' of Mitsuba 3 isn't here (--lenient renders without it)");
    return nullptr;
  }
  const auto category = category_of_tag(node.tag);
  if (!category && !node.is_broken) {
    faults_.add(node.where, node.tag == "scene" ? "a <scene> is not an object of its own"
                                                : quoted_tag(node) + " is not supported");
  }
  const Attribute* const type = node.find("type");
  if (!category || !type || node.is_broken) return nullptr;
  const PluginDescriptor* plugin = nullptr;
  faults_.attempt([&] { plugin = &registry_.find(*category, type->value, type->where); });
  return plugin;
}

/// What can be said of a node's children without knowing what the node is.
void Builder::look_at_parts(const Node& node, const Maker& make) {
  for (const Node& child : node.children) {
    if (is_object(child)) {
      if (const Node* target = child.tag == "ref" ? target_of(child) : &child) make(*target);
    } else if (!child.is_broken && kind_of(child) != TagKind::kOperation) {
      faults_.attempt([&] { convert(child, nullptr, *folders(child)); });
    }
  }
}

Builder::Parts Builder::read_parts(const Node& node, const PluginDescriptor& plugin,
                                   const Maker& make) {
  Parts parts{Properties(*category_of_tag(node.tag), node.value("type"), node.where), {}};
  parts.props.set_id(node.value("id"));
  parts.props.set_search_paths(folders(node));
  int unnamed = 0;
  for (const Node& child : node.children) {
    const bool has_name =
        child.is_broken ? has_certain(child, "name") : child.find("name") != nullptr;
    const std::string name = has_name ? child.value("name") : "";
    if (has_name && node.is_given(name)) continue;
    if (is_object(child)) {
      add_object(child, has_name ? name : "_arg_" + std::to_string(unnamed++), plugin, make, parts);
    } else {
      add_value(child, name, plugin, parts);
    }
  }
  add_given(node, plugin, parts);
  return parts;
}

/// What a program sets.
void Builder::add_given(const Node& node, const PluginDescriptor& plugin, Parts& parts) {
  for (const ObjectDescription::Value& given : node.given) {
    const bool is_known = find_row(plugin, given.name);
    if (!is_known && is_of_mitsubas_working(parts.props.category(), given.name)) continue;
    faults_.attempt([&] { parts.props.set(given.name, given.value, given.where); });
  }
}

void Builder::add_value(const Node& child, const std::string& name, const PluginDescriptor& plugin,
                        Parts& parts) {
  if (!find_row(plugin, name) && is_of_mitsubas_working(parts.props.category(), name)) {
    log_info(Error(child.where, "'" + name + "' means nothing here, and is ignored").what());
    return;
  }
  const bool is_whole =
      !child.is_broken && std::none_of(child.children.begin(), child.children.end(),
                                       [](const Node& part) { return part.is_broken; });
  Properties::Value value;
  const bool is_fine = !child.is_broken && faults_.attempt([&] {
    value = convert(child, find_row(plugin, name), *folders(child));
  });
  if (is_whole && is_fine) {
    faults_.attempt([&] { parts.props.set(name, std::move(value), child.where); });
  } else if (name.empty()) {
    parts.lost.anything = true;
  } else {
    parts.lost.names.insert(name);
  }
}

void Builder::add_object(const Node& child, std::string name, const PluginDescriptor& plugin,
                         const Maker& make, Parts& parts) {
  const Node* const target = child.tag == "ref" ? target_of(child) : &child;
  const auto category = target ? category_of_tag(target->tag) : std::nullopt;
  std::shared_ptr<Object> object = target ? make(*target) : nullptr;
  if (category == Category::kTexture && !find_row(plugin, name)) {
    name = row_of_any_texture(plugin).value_or(name);
  }
  if (!object && category == Category::kBsdf) object = make_black_bsdf();
  if (!object && category == Category::kTexture) object = make_uniform_texture(Rgb(kStandIn));
  if (category == Category::kTexture && child.is_broken && !has_certain(child, "name")) {
    parts.lost.anything = true;  // of which parameter it is, isn't known
  } else if (object) {
    faults_.attempt([&] { parts.props.set(name, std::move(object), child.where); });
  } else if (category) {
    parts.lost.categories.insert(*category);
  } else {
    parts.lost.anything = true;
  }
}

/// All that can be said of a BSDF or texture without making it.
void Builder::check(const Node& node) {
  if (!checked_.insert(&node).second) return;
  const UnderWay under_way(*this, node);
  if (under_way.is_too_deep()) return;
  for (const Node& child : node.children) {
    if (child.tag != "ref") continue;
    if (const Node* const target = target_of(child)) named_by_unused_.insert(target);
  }
  const auto maker = [this](const Node& part) { return stand_in(part); };
  const PluginDescriptor* const plugin = find_plugin(node);
  if (!plugin) {
    if (!is_missing(node, registry_)) look_at_parts(node, maker);
    return;
  }
  Parts parts = read_parts(node, *plugin, maker);
  const std::vector<Error> faults = check_parameters(parts.props, *plugin, parts.lost);
  for (const Error& fault : faults) faults_.add(fault);
  if (!faults.empty()) return;
  parts.props.set_table(plugin->parameters);
  for (const Parameter& row : plugin->parameters) {
    // Checks a colour's range.
    if (row.type != ParameterType::kReflectanceTexture) continue;
    if (!row.required || parts.props.has(row.name)) {
      faults_.attempt([&] { parts.props.texture(row.name); });
    }
  }
}

/// An object of the node's category, for what is checked and not made.
std::shared_ptr<Object> Builder::stand_in(const Node& node) {
  if (!is_made_on_demand(node)) return object(node);
  check(node);
  if (category_of_tag(node.tag) == Category::kBsdf) return make_black_bsdf();
  return make_uniform_texture(Rgb(kStandIn));
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
  made_.push_back(name);
  if (const auto* const emitter = dynamic_cast<const Emitter*>(object.get())) {
    if (!emitter->is_surface()) check_no_attribute(*object, props.where());
  }
  if (props.category() != Category::kShape) return object;

  auto& shape = dynamic_cast<Shape&>(*object);
  // What it is made of has its own.
  if (dynamic_cast<const ShapeGroup*>(&shape) || !shape.parts().empty()) return object;
  check_attributes(shape, props.where());
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

}  // namespace kinome::loader
