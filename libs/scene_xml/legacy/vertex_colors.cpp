// The texture `vertexcolors` of Mitsuba 0.x on shapes without colours.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <fmt/format.h>

#include "scene_xml/legacy/legacy.h"

namespace kinome::loader::legacy {
namespace {

/// Shapes that never have colours of vertices here.
constexpr std::string_view kWithoutColors[] = {"cube", "cylinder",  "disk",       "hair",
                                               "obj",  "rectangle", "serialized", "sphere"};
/// Limit of nested references, against cycles.
constexpr int kMaxDepth = 32;

bool is_vertex_colors(const Node& node) {
  return node.tag == "texture" && node.is_old && node.value("type") == "vertexcolors";
}

/// Returns true if a PLY file's header names colours, or if the file can't be read, which is
/// reported later.
bool ply_has_colors(const std::string& path) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) return true;
  std::ifstream file(path, std::ios::binary);
  constexpr int kMaxLines = 1000;
  std::string line, element;
  for (int i = 0; i < kMaxLines && std::getline(file, line); ++i) {
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    if (first == "end_header") return false;
    if (first == "element") element = second;
    const bool is_red = third == "r" || third == "red" || third == "color_x" ||
                        third == "color_0" || third == "color_1";
    if (first == "property" && element == "vertex" && is_red) return true;
  }
  return true;
}

class VertexColors {
 public:
  VertexColors(const FileFinder& find_file, Warnings& warnings)
      : find_file_(find_file), warnings_(warnings) {}

  void run(Node& root) {
    collect(root);
    if (is_used_) visit(root);
  }

 private:
  void collect(const Node& node) {
    is_used_ |= is_vertex_colors(node);
    if (const Attribute* const id = node.find("id"); id && node.tag != "ref") {
      nodes_.emplace(id->value, &node);
    }
    for (const Node& child : node.children) collect(child);
  }

  void visit(Node& node) {
    if (node.tag == "shape" && node.is_old && !node.is_broken && !has_colors(node)) {
      for (Node& child : node.children) {
        if (child.tag != "shape" && uses_colors(child, 0)) blacken(child, 0);
      }
    }
    for (Node& child : node.children) visit(child);
  }

  bool has_colors(Node& shape) const {
    const std::string type = shape.value("type");
    if (std::find(std::begin(kWithoutColors), std::end(kWithoutColors), type) !=
        std::end(kWithoutColors)) {
      return false;
    }
    const Node* const file = find_child(shape, "filename");
    return type != "ply" || !file || ply_has_colors(find_file_(shape, file->value("value")));
  }

  const Node* target_of(const Node& ref) const {
    const auto found = nodes_.find(ref.value("id"));
    return found == nodes_.end() ? nullptr : found->second;
  }

  bool uses_colors(const Node& node, int depth) const {
    if (depth > kMaxDepth) return false;
    if (node.tag == "ref") {
      const Node* const target = target_of(node);
      return target && target->tag != "shape" && uses_colors(*target, depth + 1);
    }
    return is_vertex_colors(node) ||
           std::any_of(node.children.begin(), node.children.end(),
                       [&](const Node& child) { return uses_colors(child, depth + 1); });
  }

  /// Makes the colours in an object black. Other shapes may refer to it: a reference is replaced
  /// by a copy.
  void blacken(Node& node, int depth) {
    if (node.tag == "ref") {
      Node copy = *target_of(node);
      drop_ids(copy);
      std::erase_if(copy.attributes, [](const Attribute& a) { return a.name == "name"; });
      if (const Attribute* const name = node.find("name")) copy.attributes.push_back(*name);
      node = std::move(copy);
    }
    if (is_vertex_colors(node)) {
      warnings_.add(node.where, "'vertexcolors' is replaced by black for shapes without colours");
      node.children.clear();
      set_type(node, "checkerboard");
      for (const char* const name : {"color0", "color1"}) add_number(node, name, 0);
      return;
    }
    for (Node& child : node.children) {
      if (uses_colors(child, depth + 1)) blacken(child, depth + 1);
    }
  }

  static void drop_ids(Node& node) {
    if (node.tag == "ref") return;
    std::erase_if(node.attributes, [](const Attribute& a) { return a.name == "id"; });
    for (Node& child : node.children) drop_ids(child);
  }

  const FileFinder& find_file_;
  Warnings& warnings_;
  std::map<std::string, const Node*> nodes_;  ///< by their ids
  bool is_used_ = false;
};

}  // namespace

void translate_vertex_colors(Node& root, const FileFinder& find_file, Warnings& warnings) {
  VertexColors(find_file, warnings).run(root);
}

}  // namespace kinome::loader::legacy
