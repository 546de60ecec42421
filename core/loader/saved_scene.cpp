#include "loader/saved_scene.h"

#include <algorithm>
#include <filesystem>

#include "base/file_writer.h"
#include "base/read_files.h"
#include "kinome/image.h"
#include "loader/saved_mesh.h"
#include "loader/written_values.h"

namespace kinome::loader {
namespace {

namespace fs = std::filesystem;

/// For a name of a file: what is no letter, digit or dot becomes an underscore.
std::string plain_name(const std::string& text) {
  std::string plain;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '.' || c == '-';
    plain += is_plain ? c : '_';
  }
  return plain.substr(0, 100);
}

/// It, and what it was put around, and so on: no text says any of it.
bool is_put_alone(const Node& node) {
  return node.is_put && (!node.inner || is_put_alone(*node.inner));
}

}  // namespace

SavedScene::SavedScene(const Node& root, Builder& builder, const ParameterList& parameters,
                       const EditedMeshes& meshes, const std::string& path)
    : builder_(builder), parameters_(parameters), meshes_(meshes) {
  const fs::path folder = fs::path(path).parent_path();
  folder_ = (folder.empty() ? fs::path(".") : folder).string();
  stem_ = fs::path(path).stem().string();
  for (const auto& [object, node] : parameters.objects()) paths_[node] = object;
  look_at(root);
}

void SavedScene::look_at(const Node& node) {
  if (node.tag == "scene" || (node.tag != "ref" && category_of_tag(node.tag))) add(node);
  for_each_part(node, [this](const Node& child) { look_at(child); });
}

void SavedScene::add(const Node& node) {
  const auto mesh = meshes_.find(&node);
  if (mesh == meshes_.end() && node.given.empty() && node.taken.empty()) return;
  const auto known = paths_.find(&node);
  const std::string path = known != paths_.end() ? known->second : node.tag;
  Said said{node.value("type"), {}, {}, {node.taken.begin(), node.taken.end()}};
  for (const auto& put : node.put) said.objects.push_back(put.get());
  if (mesh != meshes_.end()) {
    // Its other parameters have done what they do.
    said.type = "ply";
    for (const Node& child : node.children) {
      if (!is_object(child)) said.unsaid.insert(child.value("name"));
    }
    const std::string name = new_name(path, ".ply");
    const auto shape = builder_.made_of(node);
    SavedMesh saved = saved_mesh(dynamic_cast<const MeshShape&>(*shape), mesh->second, name);
    said.values = std::move(saved.values);
    arrays_.push_back({(fs::path(folder_) / name).string(), std::move(saved.bytes), nullptr});
  } else {
    for (const ObjectDescription::Value& given : node.given) {
      const auto* const pixels = std::get_if<std::shared_ptr<const Image>>(&given.value);
      said.unsaid.insert(given.name);
      if (!pixels) {
        said.values.push_back(given);
        auto* const text = std::get_if<std::string>(&said.values.back().value);
        if (text) *text = relocated_value(node, given.name, *text);
        continue;
      }
      const std::string name = new_name(path, ".exr");
      arrays_.push_back({(fs::path(folder_) / name).string(), "", *pixels});
      said.unsaid.insert("filename");
      said.values.push_back({"filename", name, given.where});
    }
  }
  for (const auto& value : said.values) said.unsaid.insert(value.name);
  for (const auto& value : said.values) {
    expect_no_name(value.name, value.where);
    if (const auto* const text = std::get_if<std::string>(&value.value)) {
      expect_no_name(*text, value.where);
    }
  }
  said_.emplace(&node, std::move(said));
}

void SavedScene::write_arrays() const {
  for (const Array& array : arrays_) {
    if (array.pixels) {
      write_exr(array.path, *array.pixels, ExrNumber::kFloat, {});
      continue;
    }
    FileWriter writer(array.path);
    writer.write(array.bytes.data(), array.bytes.size());
    writer.commit();
  }
}

const SavedScene::Said* SavedScene::find(const Node& node) const {
  const auto found = said_.find(&node);
  return found == said_.end() ? nullptr : &found->second;
}

std::vector<std::pair<std::string, std::string>> SavedScene::elements(const Node& node) const {
  std::vector<std::pair<std::string, std::string>> all;
  const Said* const said = find(node);
  if (!said) return all;
  for (const auto& [name, value, where] : said->values) {
    const auto is_of_it = [&of = name](const auto& one) { return one->value("name") == of; };
    const auto steps = std::find_if(node.steps.begin(), node.steps.end(), is_of_it);
    all.emplace_back(name, steps != node.steps.end() ? element(**steps)
                                                     : value_element(name, value, row(node, name)));
  }
  for (const Node* const put : said->objects) all.emplace_back(put->value("name"), element(*put));
  return all;
}

std::string SavedScene::element(const Node& node) const {
  std::string text = "<" + node.tag;
  for (const Attribute& attribute : node.attributes) {
    text += " " + attribute.name + "=\"" + said_text(attribute.value, attribute.where) + "\"";
  }
  const std::string inside = contents(node);
  return text + (inside.empty() ? "/>" : ">" + inside + "</" + node.tag + ">");
}

std::string SavedScene::contents(const Node& node) const {
  std::string text;
  for (const auto& [name, said] : elements(node)) text += said;
  for (const Node& child : node.children) {
    if (!node.is_overridden(child.value("name"))) text += element(child);
  }
  if (node.inner && is_put_alone(*node.inner)) text += element(*node.inner);
  return text;
}

const Parameter* SavedScene::row(const Node& node, const std::string& name) const {
  if (!category_of_tag(node.tag)) return nullptr;
  const PluginDescriptor* const plugin = parameters_.known_plugin_of(node);
  return plugin ? find_row(*plugin, name) : nullptr;
}

std::string SavedScene::relocated(const std::string& name, const std::string& found) const {
  std::error_code failed;
  if (found.empty() || fs::path(name).is_absolute()) return name;
  if (fs::equivalent(fs::path(folder_) / name, found, failed)) return name;
  const fs::path from = fs::weakly_canonical(fs::absolute(folder_, failed), failed);
  const fs::path to = fs::weakly_canonical(fs::absolute(found, failed), failed);
  const fs::path way = to.lexically_relative(from);
  return (way.empty() ? to : way).generic_string();
}

std::string SavedScene::relocated_value(const Node& node, const std::string& parameter,
                                        const std::string& name) const {
  const Parameter* const known = row(node, parameter);
  if (!known || known->type != ParameterType::kFile) return name;
  return relocated(name, builder_.file_of(node, name));
}

std::string SavedScene::new_name(const std::string& name, const std::string& ending,
                                 const std::string& replaced) {
  // What was written beside the same scene before keeps its name, unless it is still read.
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
