#include "scene_xml/objects/build.h"

#include <fmt/format.h>

#include <algorithm>

#include "kinome/log.h"
#include "kinome/mitsuba_plugins.h"
#include "kinome/texture.h"
#include "kinome/volume.h"
#include "plugin/property_types.h"
#include "scene_xml/values/convert.h"

namespace kinome::loader {
namespace {

/// Value of the placeholder for a texture with an error; valid for all parameters.
constexpr float kPlaceholder = 0.5f;

/// Returns a placeholder for an object that is made on demand.
std::shared_ptr<Object> placeholder_of(Category category) {
  if (category == Category::kBsdf) return make_black_bsdf();
  if (category == Category::kVolume) return std::make_shared<UniformVolume>(Rgb(kPlaceholder));
  return make_uniform_texture(Rgb(kPlaceholder));
}

/// Returns true if an object can be made without the lost properties, so that further errors in it
/// are found. This requires that they are optional.
bool can_be_made_without(const Lost& lost, const PluginDescriptor& plugin) {
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

/// Returns the parameter that takes textures of any name, or without a name.
std::optional<std::string> row_of_any_texture(const PluginDescriptor& plugin) {
  for (const Parameter& row : plugin.parameters) {
    if (row.type == ParameterType::kObject && row.category == Category::kTexture && !row.by_name) {
      return row.name;
    }
  }
  return std::nullopt;
}

}  // namespace

const char* why_ignored(Category category, const std::string& name) {
  struct Ignored {
    Category category;
    const char* name;
    const char* why;
  };
  constexpr Ignored kAll[] = {
      {Category::kEmitter, "sampling_weight", "integrators choose emitters by themselves"},
      {Category::kIntegrator, "block_size", "the size of tiles doesn't change the image"},
      {Category::kIntegrator, "samples_per_pass", "passes don't change the image"},
      {Category::kIntegrator, "timeout", "--time limits the time of a render"},
      {Category::kShape, "silhouette_sampling_weight", "it only affects derivatives of images"},
  };
  const auto found = std::find_if(std::begin(kAll), std::end(kAll), [&](const Ignored& one) {
    return one.category == category && name == one.name;
  });
  return found == std::end(kAll) ? nullptr : found->why;
}

bool is_made_on_demand(const Node& node) {
  const auto category = category_named(node.tag);
  return category == Category::kBsdf || category == Category::kTexture ||
         category == Category::kVolume;
}

bool is_object(const Node& node) {
  const TagKind kind = kind_of(node);
  return kind == TagKind::kObject || kind == TagKind::kRef || kind == TagKind::kInclude;
}

Builder::Builder(const Expansion& expansion, std::vector<std::string> base_folders,
                 PluginRegistry& registry, Faults& faults, unsigned threads)
    : expansion_(expansion),
      base_folders_(std::move(base_folders)),
      registry_(registry),
      faults_(faults),
      threads_(threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency())) {
  for_each_id(expansion.root,
              [&](const std::string& id, const Node& node) { ids_.emplace(id, &node); });
}

const Node* Builder::target_of(const Node& ref) {
  if (ref.is_broken) return nullptr;
  const Attribute& id = *ref.find("id");
  const std::string target = unaliased(expansion_.aliases, id.value);
  const auto found = ids_.find(target);
  if (found != ids_.end()) {
    if (!under_construction_.count(found->second)) return found->second;
    faults_.add(id.where, "'" + id.value + "' refers to an object that it is part of");
    return nullptr;
  }
  if (expansion_.has_unknown_ids || expansion_.lost_ids.count(target)) return nullptr;
  std::vector<std::string> known;
  for (const auto& entry : ids_) known.push_back(entry.first);
  for (const auto& entry : expansion_.aliases) known.push_back(entry.first);
  faults_.add(id.where, "unknown id '" + id.value + "'" +
                            did_you_mean(faults_.nearest(id.value, known)));
  return nullptr;
}

/// Marks a node as under construction while its nested objects are made.
class Builder::UnderConstruction {
 public:
  UnderConstruction(Builder& builder, const Node& node) : builder_(builder), node_(node) {
    builder_.under_construction_.insert(&node_);
  }
  ~UnderConstruction() { builder_.under_construction_.erase(&node_); }
  UnderConstruction(const UnderConstruction&) = delete;
  UnderConstruction& operator=(const UnderConstruction&) = delete;
  bool is_too_deep() const {
    if (builder_.under_construction_.size() <= kMaxObjectDepth) return false;
    builder_.faults_.add(node_.where, "objects are nested too deeply");
    return true;
  }

 private:
  Builder& builder_;
  const Node& node_;
};

std::shared_ptr<Object> Builder::object(const Node& node) {
  if (const auto known = objects_.find(&node); known != objects_.end()) return known->second;
  const UnderConstruction under_construction(*this, node);
  auto object = under_construction.is_too_deep() ? nullptr : make(node);
  objects_[&node] = object;
  return object;
}

std::shared_ptr<Object> Builder::make(const Node& node) {
  const auto maker = [this](const Node& part) { return object(part); };
  const PluginDescriptor* const plugin = find_plugin(node);
  if (!plugin) {
    if (!is_missing(node, registry_)) check_parts(node, maker);
    return nullptr;
  }
  auto begun = begun_.extract(&node);
  std::optional<Parts> own;
  if (!begun) own = read_parts(node, *plugin, maker);
  Parts& parts = begun ? begun.mapped().parts : *own;
  std::shared_ptr<Object> made;
  if (can_be_made_without(parts.lost, *plugin)) {
    faults_.attempt([&] {
      made = create(parts.props, node.find("type")->where, begun ? &begun.mapped().object : nullptr);
    });
  } else {
    for (const Error& fault : check_parameters(parts.props, *plugin, parts.lost)) {
      faults_.add(fault);
    }
  }
  return made;
}

/// Makes the properties of an object that reads files, and begins to make the object itself.
void Builder::begin(const Node& node) {
  const PluginDescriptor* const plugin = reader_of(node);
  if (!plugin) return;
  const UnderConstruction under_construction(*this, node);
  if (under_construction.is_too_deep()) return;
  const auto maker = [this](const Node& part) { return object(part); };
  Begun& begun = begun_.emplace(&node, Begun{read_parts(node, *plugin, maker), {}}).first->second;
  if (!can_be_made_without(begun.parts.lost, *plugin)) return;
  begun.object = ahead_->begin(
      [&props = begun.parts.props, plugin] { return PluginRegistry::create(*plugin, props); },
      memory_to_read(node, *plugin));
}

/// Finds the plugin of a node. Returns nullptr after reporting an error, for instance an unknown
/// plugin.
const PluginDescriptor* Builder::find_plugin(const Node& node) {
  if (is_missing(node, registry_)) {
    const std::string& type = node.find("type")->value;
    faults_.add(node.find("type")->where,
                "unsupported " + node.tag + " '" + type + "'" +
                    (is_of_mitsuba(node.tag, type) ? " of Mitsuba 3" : "") +
                    " (--lenient renders without it)");
    return nullptr;
  }
  const auto category = category_named(node.tag);
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

/// Checks the children of a node whose plugin is unknown.
void Builder::check_parts(const Node& node, const Maker& make) {
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
  Parts parts{Properties(*category_named(node.tag), node.value("type"), node.where), {}};
  parts.props.set_id(node.value("id"));
  parts.props.set_search_paths(folders(node));
  int unnamed = 0;
  for (const Node& child : node.children) {
    const bool has_name =
        child.is_broken ? has_certain(child, "name") : child.find("name") != nullptr;
    const std::string name = has_name ? child.value("name") : "";
    if (has_name && node.is_overridden(name)) continue;
    if (is_object(child)) {
      add_object(child, has_name ? name : "_arg_" + std::to_string(unnamed++), plugin, make, parts);
    } else {
      add_value(child, name, plugin, parts);
    }
  }
  for (const auto& inserted : node.inserted)
    add_object(*inserted, inserted->value("name"), plugin, make, parts);
  if (node.inner) {
    add_object(*node.inner, "_arg_" + std::to_string(unnamed), plugin, make, parts);
  }
  add_overrides(node, plugin, parts);
  return parts;
}

/// Adds the values that a program has set.
void Builder::add_overrides(const Node& node, const PluginDescriptor& plugin, Parts& parts) {
  for (const ObjectDescription::Value& value : node.overrides) {
    const bool is_known = find_row(plugin, value.name);
    const char* const why = is_known ? nullptr : why_ignored(parts.props.category(), value.name);
    if (why) {
      warn_once_of_ignored(parts.props, value.name, why, value.where);
      continue;
    }
    faults_.attempt([&] { parts.props.set(value.name, value.value, value.where); });
  }
}

void Builder::add_value(const Node& child, const std::string& name, const PluginDescriptor& plugin,
                        Parts& parts) {
  const bool is_known = find_row(plugin, name);
  if (const char* why = is_known ? nullptr : why_ignored(parts.props.category(), name)) {
    warn_once_of_ignored(parts.props, name, why, child.where);
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
  const auto category = target ? category_named(target->tag) : std::nullopt;
  std::shared_ptr<Object> object = target ? make(*target) : nullptr;
  if (category == Category::kTexture) {
    const std::optional<std::string> any_name = row_of_any_texture(plugin);
    if (any_name && !find_row(plugin, name)) name = *any_name;
    for (const auto& [other, first] : parts.props.entries()) {
      if (name != any_name || other != name) continue;
      faults_.add(child.where, fmt::format("{} '{}' takes at most 1 texture (the first is at {})",
                                           to_string(parts.props.category()),
                                           parts.props.plugin_name(), to_string(first.where)));
      return;
    }
  }
  if (category == Category::kTexture && parts.props.category() == Category::kShape &&
      !find_row(plugin, name)) {
    // Mitsuba keeps any texture of a shape as an attribute for use by programs.
    warn_once_of_ignored(parts.props, name, "textures of shapes themselves are not read",
                         child.where);
    return;
  }
  if (category == Category::kMedium && parts.props.category() == Category::kEmitter &&
      !find_row(plugin, name)) {
    warn_once_of_ignored(parts.props, "medium", "rays find their media at shapes and the sensor", child.where);
    return;
  }
  if (!object && category && is_made_on_demand(*target)) object = placeholder_of(*category);
  const bool is_named = category == Category::kTexture || category == Category::kVolume;
  if (is_named && child.is_broken && !has_certain(child, "name")) {
    parts.lost.anything = true;  // its parameter is unknown
  } else if (object) {
    faults_.attempt([&] { parts.props.set(name, std::move(object), child.where); });
  } else if (category) {
    parts.lost.categories.insert(*category);
  } else {
    parts.lost.anything = true;
  }
}

/// Checks a BSDF or texture without making it.
void Builder::check(const Node& node) {
  if (!checked_.insert(&node).second) return;
  const UnderConstruction under_construction(*this, node);
  if (under_construction.is_too_deep()) return;
  for (const Node& child : node.children) {
    if (child.tag != "ref") continue;
    if (const Node* const target = target_of(child)) referenced_by_unused_.insert(target);
  }
  const auto maker = [this](const Node& part) { return placeholder(part); };
  const PluginDescriptor* const plugin = find_plugin(node);
  if (!plugin) {
    if (!is_missing(node, registry_)) check_parts(node, maker);
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

/// Returns the object of a node, or a placeholder for a BSDF or texture, which is checked and not
/// made.
std::shared_ptr<Object> Builder::placeholder(const Node& node) {
  if (!is_made_on_demand(node)) return object(node);
  check(node);
  return placeholder_of(*category_named(node.tag));
}

std::shared_ptr<const std::vector<std::string>> Builder::folders(const Node& node) {
  auto& list = folder_lists_[node.folders.get()];
  if (!list) {
    list = std::make_shared<const std::vector<std::string>>(
        search_folders(node.folders.get(), expansion_.paths, base_folders_));
  }
  return list;
}

}  // namespace kinome::loader
