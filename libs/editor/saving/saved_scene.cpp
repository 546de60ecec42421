#include "editor/saving/saved_scene.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/read_files.h"
#include "editor/saving/saved_grid.h"
#include "editor/saving/saved_mesh.h"
#include "editor/saving/written_values.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "kinome/mesh_shape.h"
#include "output_files/file_writer.h"

namespace kinome::loader {
namespace {

namespace fs = std::filesystem;

/// Returns a text for a file name, with underscores for all characters except letters, digits, dots
/// and dashes.
std::string plain_name(const std::string& text) {
  std::string plain;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '.' || c == '-';
    plain += is_plain ? c : '_';
  }
  return plain.substr(0, 100);
}

/// Returns true if the node and all BSDFs that it wraps were inserted by a program.
bool is_inserted_with_all_inner(const Node& node) {
  return node.is_inserted && (!node.inner || is_inserted_with_all_inner(*node.inner));
}

}  // namespace

SavedScene::SavedScene(const Node& root, Builder& builder, const ParameterList& parameters,
                       const EditedMeshes& meshes, const std::string& path)
    : builder_(builder), parameters_(parameters), meshes_(meshes) {
  const fs::path folder = fs::path(path).parent_path();
  folder_ = (folder.empty() ? fs::path(".") : folder).string();
  stem_ = fs::path(path).stem().string();
  for (const auto& [object, node] : parameters.objects()) paths_[node] = object;
  visit(root);
}

void SavedScene::visit(const Node& node) {
  if (node.tag == "scene" || (node.tag != "ref" && category_named(node.tag))) add(node);
  for_each_part(node, [this](const Node& child) { visit(child); });
}

void SavedScene::add(const Node& node) {
  const auto mesh = meshes_.find(&node);
  if (mesh == meshes_.end() && node.overrides.empty() && node.removed.empty()) return;
  const auto known = paths_.find(&node);
  const std::string path = known != paths_.end() ? known->second : node.tag;
  Changes changes{node.value("type"), {}, {}, {node.removed.begin(), node.removed.end()}};
  for (const auto& inserted : node.inserted) changes.objects.push_back(inserted.get());
  if (mesh != meshes_.end()) {
    // All other parameters are already applied to the mesh.
    changes.type = "ply";
    for (const Node& child : node.children) {
      if (!is_object(child)) changes.overridden.insert(child.value("name"));
    }
    const std::string name = new_name(path, ".ply");
    const auto shape = builder_.made_of(node);
    SavedMesh saved = saved_mesh(dynamic_cast<const MeshShape&>(*shape), mesh->second, name);
    changes.values = std::move(saved.values);
    arrays_.push_back({(fs::path(folder_) / name).string(), std::move(saved.bytes), nullptr});
  } else {
    for (const ObjectDescription::Value& set : node.overrides) {
      const auto* const pixels = std::get_if<std::shared_ptr<const Image>>(&set.value);
      changes.overridden.insert(set.name);
      const bool is_grid = node.tag == "volume";
      if (is_grid && set.name == "slices") continue;  // part of the grid's file
      if (!pixels) {
        changes.values.push_back(set);
        auto* const text = std::get_if<std::string>(&changes.values.back().value);
        if (text) *text = relocated_value(node, set.name, *text);
        continue;
      }
      const std::string name = new_name(path, is_grid ? ".vol" : ".exr");
      const std::string file = (fs::path(folder_) / name).string();
      if (is_grid) {
        changes.overridden.insert("slices");
        arrays_.push_back({file, saved_grid(**pixels, slices_of(node)), nullptr});
      } else {
        arrays_.push_back({file, "", *pixels});
      }
      changes.overridden.insert("filename");
      changes.values.push_back({"filename", name, set.where});
    }
  }
  for (const auto& value : changes.values) changes.overridden.insert(value.name);
  for (const auto& value : changes.values) {
    expect_no_name(value.name, value.where);
    if (const auto* const text = std::get_if<std::string>(&value.value)) {
      expect_no_name(*text, value.where);
    }
  }
  changes_.emplace(&node, std::move(changes));
}

/// Number of slices of a grid's `data`.
int SavedScene::slices_of(const Node& node) const {
  std::optional<Properties::Value> value;
  if (const Parameter* const slices = row(node, "slices")) value = builder_.written(node, *slices);
  for (const ObjectDescription::Value& set : node.overrides) {
    if (set.name == "slices") value = set.value;
  }
  const auto* const number = value ? std::get_if<int64_t>(&*value) : nullptr;
  return number ? static_cast<int>(*number) : 1;
}

void SavedScene::write_arrays() const {
  for (const Array& array : arrays_) {
    if (array.pixels) {
      write_exr(array.path, *array.pixels, ExrSampleType::kFloat, {});
      continue;
    }
    FileWriter writer(array.path);
    writer.write(array.bytes.data(), array.bytes.size());
    writer.commit();
  }
}

const SavedScene::Changes* SavedScene::find(const Node& node) const {
  const auto found = changes_.find(&node);
  return found == changes_.end() ? nullptr : &found->second;
}

std::vector<std::pair<std::string, std::string>> SavedScene::elements(const Node& node) const {
  std::vector<std::pair<std::string, std::string>> all;
  const Changes* const changes = find(node);
  if (!changes) return all;
  for (const auto& [name, value, where] : changes->values) {
    const auto has_name = [&of = name](const auto& one) { return one->value("name") == of; };
    const auto steps = std::find_if(node.steps.begin(), node.steps.end(), has_name);
    all.emplace_back(name, steps != node.steps.end() ? element(**steps)
                                                     : value_element(name, value, row(node, name)));
  }
  for (const Node* const inserted : changes->objects)
    all.emplace_back(inserted->value("name"), element(*inserted));
  return all;
}

std::string SavedScene::element(const Node& node) const {
  std::string text = "<" + node.tag;
  for (const Attribute& attribute : node.attributes) {
    text += " " + attribute.name + "=\"" + attribute_text(attribute.value, attribute.where) + "\"";
  }
  const std::string inside = contents(node);
  return text + (inside.empty() ? "/>" : ">" + inside + "</" + node.tag + ">");
}

std::string SavedScene::contents(const Node& node) const {
  std::string text;
  for (const auto& [name, xml] : elements(node)) text += xml;
  for (const Node& child : node.children) {
    if (!node.is_overridden(child.value("name"))) text += element(child);
  }
  if (node.inner && is_inserted_with_all_inner(*node.inner)) text += element(*node.inner);
  return text;
}

const Parameter* SavedScene::row(const Node& node, const std::string& name) const {
  if (!category_named(node.tag)) return nullptr;
  const PluginDescriptor* const plugin = parameters_.known_plugin_of(node);
  return plugin ? find_row(*plugin, name) : nullptr;
}

std::string SavedScene::relocated(const std::string& name, const std::string& found) const {
  std::error_code failed;
  if (found.empty() || fs::path(name).is_absolute()) return name;
  if (fs::equivalent(fs::path(folder_) / name, found, failed)) return name;
  const fs::path from = fs::weakly_canonical(fs::absolute(folder_, failed), failed);
  const fs::path to = fs::weakly_canonical(fs::absolute(found, failed), failed);
  const fs::path relative = to.lexically_relative(from);
  return (relative.empty() ? to : relative).generic_string();
}

std::string SavedScene::relocated_value(const Node& node, const std::string& parameter,
                                        const std::string& name) const {
  const Parameter* const known = row(node, parameter);
  if (!known || known->type != ParameterType::kFile) return name;
  return relocated(name, builder_.file_of(node, name));
}

std::string SavedScene::new_name(const std::string& name, const std::string& ending,
                                 const std::string& replaced) {
  // Files of earlier saves are overwritten, unless the scene still reads them.
  const std::string wanted = (name.starts_with(stem_ + "-") ? "" : stem_ + "-") + plain_name(name);
  std::string unused = wanted + ending;
  std::error_code failed;
  const fs::path own = replaced.empty() ? fs::path() : fs::weakly_canonical(replaced, failed);
  const auto is_read = [&] {
    const fs::path path = fs::weakly_canonical(fs::path(folder_) / unused, failed);
    return path != own && is_read_file(path.string());
  };
  for (int i = 1; is_read() || !names_.insert(unused).second; ++i) {
    unused = wanted + "_" + std::to_string(i) + ending;
  }
  return unused;
}

}  // namespace kinome::loader
