// Writes a scene's file.

#include "editor/saving/scene_writer.h"

#include <filesystem>

#include <fmt/format.h>

#include "editor/saving/patched_scene.h"
#include "editor/saving/written_values.h"
#include "output_files/file_writer.h"

namespace kinome::loader {
namespace {

/// Writes an include. May overwrite a file that the scene has read, because an earlier save may
/// have written it.
void write_include(const std::string& path, const std::string& text) {
  FileWriter writer(path, FileWriter::ReadFile::kReplace);
  writer.write(text.data(), text.size());
  writer.commit();
}

class SceneGenerator {
 public:
  SceneGenerator(const Expansion& expansion, const SavedScene& saved)
      : expansion_(expansion), saved_(saved) {}

  std::string run() {
    add_values(expansion_.root, "  ");
    for (const Node& child : expansion_.root.children) add(child, expansion_.root, 1);
    return "<scene version=\"3.0.0\">\n" + kept_ + text_ + "</scene>\n";
  }

 private:
  void add_values(const Node& node, const std::string& indent) {
    for (const auto& [name, element] : saved_.elements(node)) text_ += indent + element + "\n";
  }

  void add(const Node& node, const Node& owner, int depth) {
    const std::string name = node.value("name");
    const SavedScene::Changes* const outer = saved_.find(owner);
    if (outer && !name.empty() && outer->overridden.count(name)) {
      // Other objects may refer to it, so that it must stay in the file.
      if (is_object(node) && node.tag != "ref") keep_elsewhere(node);
      return;
    }
    add_element(node, owner, depth, true);
  }

  void add_element(const Node& node, const Node& owner, int depth, bool has_name) {
    const SavedScene::Changes* const changes = saved_.find(node);
    const std::string indent(static_cast<size_t>(2 * depth), ' ');
    text_ += indent + "<" + node.tag;
    for (const Attribute& attribute : node.attributes) {
      if (attribute.name == "name" && !has_name) continue;
      text_ +=
          fmt::format(" {}=\"{}\"", attribute.name,
                      attribute_text(value_of(node, owner, attribute, changes), attribute.where));
    }
    if (node.children.empty() && !node.inner && saved_.elements(node).empty()) {
      text_ += "/>\n";
      return;
    }
    text_ += ">\n";
    add_values(node, indent + "  ");
    for (const Node& child : node.children) add(child, node, depth + 1);
    if (node.inner) add_element(*node.inner, node, depth + 1, true);
    text_ += indent + "</" + node.tag + ">\n";
  }

  std::string value_of(const Node& node, const Node& owner, const Attribute& attribute,
                       const SavedScene::Changes* changes) const {
    if (attribute.name == "type" && changes) return changes->type;
    if (attribute.name == "id" && node.tag == "ref") {
      return unaliased(expansion_.aliases, attribute.value);
    }
    if (attribute.name == "filename") return saved_.relocated_file(node, attribute.value);
    if (attribute.name == "value" && node.tag == "string") {
      return saved_.relocated_value(owner, node.value("name"), attribute.value);
    }
    return attribute.value;
  }

  void keep_elsewhere(const Node& node) {
    const std::string before = std::exchange(text_, "");
    add_element(node, expansion_.root, 1, false);
    kept_ += std::exchange(text_, before);
  }

  const Expansion& expansion_;
  const SavedScene& saved_;
  std::string text_;
  std::string kept_;
};

}  // namespace

std::string generated_scene(const Expansion& expansion, const SavedScene& saved) {
  return SceneGenerator(expansion, saved).run();
}

void save_scene(const Expansion& expansion, const std::string& name,
                const std::map<std::string, std::string>& defines, SavedScene& saved,
                const std::string& path) {
  std::error_code failed;
  for (const auto& [file, text] : expansion.texts) {
    if (file != name && std::filesystem::equivalent(file, path, failed)) {
      throw Error("cannot write '" + path + "': the scene includes it");
    }
  }
  // All texts are created before any file is written. The scene is written last, so that it never
  // refers to missing files.
  PatchedScene patches(expansion, name, defines, saved);
  const auto patched_text = patches.text();
  const std::string text = patched_text ? *patched_text : generated_scene(expansion, saved);
  const bool is_same = std::filesystem::equivalent(path, name, failed);
  FileWriter scene(path, is_same ? FileWriter::ReadFile::kReplace : FileWriter::ReadFile::kKeep);
  scene.write(text.data(), text.size());
  saved.write_arrays();
  if (patched_text) {
    for (const auto& [include, included] : patches.includes()) write_include(include, included);
  }
  scene.commit();
}

}  // namespace kinome::loader
