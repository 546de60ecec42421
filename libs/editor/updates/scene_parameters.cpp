#include "editor/updates/scene_parameters.h"

#include <algorithm>
#include <map>
#include <set>

#include "editor/updates/edits.h"
#include "kinome/shape.h"
#include "plugin/property_types.h"

namespace kinome::loader {
namespace {

EditedValue as_edited(const Properties::Value& property) {
  return std::visit(
      [](const auto& value) -> EditedValue {
        if constexpr (std::is_constructible_v<EditedValue, decltype(value)>) {
          return value;
        } else {
          throw Error("an object is not a value");
        }
      },
      property);
}

/// Returns the nested object that is the parameter's value; nullptr if there is none.
const Node* nested_object(const Node& node, const std::string& name) {
  for (const auto& inserted : node.inserted) {
    if (inserted->value("name") == name) return inserted.get();
  }
  if (node.is_overridden(name)) return nullptr;
  for (const Node& child : node.children) {
    if (is_object(child) && child.value("name") == name) return &child;
  }
  return nullptr;
}

std::string listed_name(const Parameter& row) {
  return row.name + std::string(takes_texture(row.type) ? ".value" : "");
}

}  // namespace

ObjectDescription described(const Node& node) {
  ObjectDescription description{.tag = node.tag,
                                .type = node.value(node.tag == "spectrum" ? "value" : "type"),
                                .name = node.value("name"),
                                .id = node.tag == "ref" ? node.value("id") : "",
                                .where = node.where};
  description.values = node.overrides;
  for (const Node& child : node.children) {
    if (node.is_overridden(child.value("name"))) continue;
    description.parts.push_back(described(child));
    if (child.inner) description.parts.back().parts.push_back(described(*child.inner));
  }
  for (const auto& inserted : node.inserted) description.parts.push_back(described(*inserted));
  return description;
}

const Node* written_transform(const ParameterList::Target& target) {
  for (const Node& child : target.node->children) {
    if (child.tag == "transform" && child.value("name") == target.name) return &child;
  }
  return nullptr;
}

bool is_value(const EditedValue& edited) {
  return !std::holds_alternative<ObjectDescription>(edited) &&
         !std::holds_alternative<Unset>(edited) && !std::holds_alternative<AsWritten>(edited) &&
         !std::holds_alternative<Placed>(edited);
}

std::optional<Properties::Value> as_property(const EditedValue& edited) {
  return std::visit(
      [](const auto& value) -> std::optional<Properties::Value> {
        if constexpr (std::is_constructible_v<Properties::Value, decltype(value)>) {
          return Properties::Value(value);
        } else {
          return std::nullopt;
        }
      },
      edited);
}

std::string ParameterList::path_of(const Object& object) const {
  if (paths_of_objects_.empty()) {
    for (const auto& [path, node] : objects()) {
      paths_of_objects_.emplace(builder_.made_of(*node).get(), path);
    }
    // A part that is also an object of its own keeps its path.
    for (const auto& [path, node] : objects()) {
      const auto* const shape = dynamic_cast<const Shape*>(builder_.made_of(*node).get());
      if (!shape) continue;
      for (const auto& part : shape->parts()) paths_of_objects_.emplace(part.get(), path);
    }
  }
  const auto found = paths_of_objects_.find(&object);
  return found == paths_of_objects_.end() ? "" : found->second;
}

const ObjectPaths& ParameterList::paths() const {
  if (!paths_) paths_ = std::make_unique<const ObjectPaths>(root_, builder_);
  return *paths_;
}

const PluginDescriptor& ParameterList::plugin_of(const Node& node) const {
  return registry_.find(*category_named(node.tag), node.value("type"));
}

const PluginDescriptor* ParameterList::known_plugin_of(const Node& node) const {
  try {
    return &plugin_of(node);
  } catch (const Error&) {
    return nullptr;
  }
}

/// Returns the names of a mesh's arrays.
std::vector<const char*> ParameterList::arrays_of(const Node& node) const {
  return mesh_arrays(builder_.made_of(node).get());
}

std::optional<EditedValue> ParameterList::current_value(const Node& node,
                                                        const Parameter& row) const {
  for (const auto& [name, value, where] : node.overrides) {
    if (name == row.name) return as_edited(value);
  }
  if (node.is_overridden(row.name)) return std::nullopt;
  const auto written = builder_.written(node, row);
  return written ? std::optional(as_edited(*written)) : std::nullopt;
}

SceneParameter ParameterList::described(const Node& node, const Parameter& row) const {
  SceneParameter parameter;
  parameter.kind = row.type;
  parameter.type = to_string(row.type);
  parameter.doc = row.doc;
  parameter.choices.assign(row.choices.begin(), row.choices.end());
  if (row.default_value) {
    parameter.default_value = as_edited(parse_default(row));
  } else if (row.type == ParameterType::kTransform) {
    parameter.default_value = Transform();
  }
  parameter.value = current_value(node, row);
  parameter.is_set = parameter.value.has_value();
  parameter.is_edited = node.is_overridden(row.name);
  if (!parameter.value) parameter.value = parameter.default_value;
  if (quantity_of(row.type) == Quantity::kReflectance && row.type != ParameterType::kVolume) {
    parameter.low = 0;
    parameter.high = 1;
  }
  return parameter;
}

std::vector<SceneParameter> ParameterList::all() const {
  std::vector<SceneParameter> all;
  std::set<std::string> used;
  const auto add = [&](const Node& node, const std::string& path, SceneParameter parameter) {
    parameter.path = path;
    parameter.plugin = node.tag + "/" + node.value("type");
    all.push_back(std::move(parameter));
  };
  for (const auto& [path, node] : paths().all()) {
    for (const Parameter& row : plugin_of(*node).parameters) {
      const bool is_object = row.type == ParameterType::kObject || nested_object(*node, row.name);
      if (row.ignored || is_object) continue;
      std::string own = path + "." + listed_name(row);
      // This path may be that of a nested object's parameter "value".
      if (!used.insert(own).second) own = path + "." + row.name;
      SceneParameter parameter = described(*node, row);
      if (row.type == ParameterType::kImage) parameter.value.reset();
      add(*node, own, std::move(parameter));
    }
    for (const char* const array : arrays_of(*node)) {
      SceneParameter parameter;
      parameter.type = "array";
      parameter.doc = std::string(array) == "faces" ? "three vertices of each face, from 0"
                                                    : "of each vertex, in world space";
      used.insert(path + "." + array);
      add(*node, path + "." + array, std::move(parameter));
    }
  }
  return all;
}

std::vector<SceneParameter> ParameterList::textured() const {
  std::vector<SceneParameter> all;
  std::map<const Node*, const std::string*> known;
  for (const auto& [path, node] : paths().all()) known[node] = &path;
  for (const auto& [path, node] : paths().all()) {
    for (const Parameter& row : plugin_of(*node).parameters) {
      const Node* const nested = takes_texture(row.type) ? nested_object(*node, row.name) : nullptr;
      const Node* const texture = nested ? builder_.resolved(*nested) : nullptr;
      if (!texture || !known.count(texture)) continue;
      SceneParameter parameter = described(*node, row);
      parameter.path = path + "." + listed_name(row);
      parameter.plugin = node->tag + "/" + node->value("type");
      parameter.value.reset();
      parameter.texture = *known.at(texture);
      all.push_back(std::move(parameter));
    }
  }
  return all;
}

std::optional<ParameterList::Target> ParameterList::find_if_any(const std::string& path) const {
  for (const auto& [found, rest] : paths().candidates(path)) {
    if (!builder_.made_of(*found)) continue;
    const size_t dot = rest.rfind(".value");
    const bool has_suffix = dot != std::string::npos && dot + 6 == rest.size();
    const std::string name = has_suffix ? rest.substr(0, dot) : rest;
    // All nodes belong to the scene, which isn't const.
    Node* const node = const_cast<Node*>(found);
    const Parameter* const row = find_row(plugin_of(*node), name);
    if (row && row->type != ParameterType::kObject && has_suffix <= takes_texture(row->type)) {
      return Target{node, row, name};
    }
    for (const char* const array : arrays_of(*node)) {
      if (rest == array) return Target{node, nullptr, array};
    }
  }
  return std::nullopt;
}

ParameterList::Target ParameterList::find(const std::string& path) const {
  auto target = find_if_any(path);
  if (!target) fail(path, all());
  return std::move(*target);
}

ParameterList::Target ParameterList::find_with_bsdfs(const std::string& path) const {
  auto target = find_if_any(path);
  if (target) return std::move(*target);
  const Node* const object = paths().object(path);
  const bool is_bsdf = object && object->tag == "bsdf" && builder_.made_of(*object);
  if (is_bsdf) return {const_cast<Node*>(object)};
  fail(path, all());
}

void ParameterList::fail(const std::string& path, const std::vector<SceneParameter>& all) const {
  std::vector<std::string> known;
  for (const SceneParameter& parameter : all) known.push_back(parameter.path);
  throw Error(Location{file_},
              "unknown parameter '" + path + "'" + did_you_mean(nearest_name(path, known)));
}

std::optional<EditedValue> ParameterList::value(const Target& target) const {
  if (!target.row) return mesh_array(*builder_.made_of(*target.node), target.name);
  if (nested_object(*target.node, target.name)) {
    throw Error(where(target), "'" + target.name + "' is a texture");
  }
  return described(*target.node, *target.row).value;
}

EditedValue ParameterList::edit_of(const Target& target) const {
  const Node& node = *target.node;
  if (target.is_object()) return node.inner ? EditedValue(loader::described(node)) : Unset{};
  if (!target.row) return mesh_array(*builder_.made_of(node), target.name);
  for (const auto& set : node.overrides) {
    if (set.name != target.name) continue;
    const bool is_placed = std::any_of(node.steps.begin(), node.steps.end(), [&](const auto& one) {
      return one->value("name") == target.name;
    });
    if (is_placed) return Placed{std::get<Transform>(set.value)};
    return as_edited(set.value);
  }
  for (const auto& inserted : node.inserted) {
    if (inserted->value("name") == target.name) return loader::described(*inserted);
  }
  return node.is_overridden(target.name) ? EditedValue(Unset{}) : AsWritten{};
}

Location ParameterList::where(const Target& target) {
  for (const Node& child : target.node->children) {
    if (child.value("name") == target.name) return child.where;
  }
  for (const auto& set : target.node->overrides) {
    if (set.name == target.name) return set.where;
  }
  return target.node->where;
}

}  // namespace kinome::loader
