#include "loader/object_paths.h"

#include <functional>
#include <set>

namespace kinome::loader {
namespace {

/// An object that stands in another one.
struct Part {
  std::string name;   ///< as it is listed
  std::string given;  ///< by the scene, or ""
  const Node* node;
};

std::string numbered(const std::string& name, int i) {
  return i == 0 ? name : name + "_" + std::to_string(i);
}

/// Textures go by the parameter that they are of, all else by its category, and what stands in the
/// scene itself by its id.
std::vector<Part> parts_of(const Node& node, const Builder& builder) {
  std::vector<Part> parts;
  std::map<std::string, int> counts;
  for (const Node& child : node.children) {
    if (!is_object(child) || child.is_broken) continue;
    const Node* const target = builder.resolved(child);
    if (!target) continue;
    const std::string given = child.value("name");
    std::string name = target->tag == "texture" ? given : "";
    if (node.tag == "scene") name = target->value("id").empty() ? given : target->value("id");
    if (name.empty()) name = numbered(target->tag, counts[target->tag]++);
    parts.push_back({std::move(name), given, target});
  }
  return parts;
}

}  // namespace

std::vector<ObjectPaths::Place> ObjectPaths::all() const {
  std::vector<Place> places;
  std::set<const Node*> known;
  const std::function<void(const Node&, const std::string&)> look_at =
      [&](const Node& node, const std::string& path) {
        if (!builder_.made_of(node) || !known.insert(&node).second) return;
        places.push_back({path, &node});
        for (const Part& part : parts_of(node, builder_)) {
          const std::string id = part.node->value("id");
          look_at(*part.node, id.empty() ? path + "." + part.name : id);
        }
      };
  for (const Part& part : parts_of(root_, builder_)) look_at(*part.node, part.name);
  return places;
}

const Node* ObjectPaths::find(const Node& from, std::string_view path) const {
  if (path.empty()) return &from;
  const std::vector<Part> parts = parts_of(from, builder_);
  // Names may have dots.
  for (size_t end = path.size(); end != std::string_view::npos && end > 0;
       end = path.rfind('.', end - 1)) {
    const std::string_view name = path.substr(0, end);
    const std::string_view rest = end == path.size() ? "" : path.substr(end + 1);
    int bsdfs = 0;
    for (const Part& part : parts) {
      bool is_it = name == part.name || (!part.given.empty() && name == part.given);
      if (part.node->tag == "bsdf" && from.tag == "bsdf") {
        // As Mitsuba calls them.
        const bool is_numbered = name.starts_with("bsdf_") || name.starts_with("brdf_");
        is_it |= is_numbered && name.substr(5) == std::to_string(bsdfs);
        ++bsdfs;
      }
      const Node* const found = is_it ? find(*part.node, rest) : nullptr;
      if (found) return found;
    }
    if (&from != &root_) continue;
    const Node* const named = builder_.with_id(std::string(name));
    const Node* const found = named ? find(*named, rest) : nullptr;
    if (found) return found;
  }
  return nullptr;
}

std::vector<std::pair<const Node*, std::string>> ObjectPaths::candidates(
    const std::string& path) const {
  std::vector<std::pair<const Node*, std::string>> found;
  for (size_t end = path.rfind('.'); end != std::string::npos && end > 0;
       end = path.rfind('.', end - 1)) {
    if (const Node* const node = find(root_, std::string_view(path).substr(0, end))) {
      found.emplace_back(node, path.substr(end + 1));
    }
  }
  return found;
}

}  // namespace kinome::loader
