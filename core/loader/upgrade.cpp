// Scene files of Mitsuba 0.6 become those of Mitsuba 3.

#include <algorithm>
#include <array>

#include "base/numbers.h"
#include "loader/node.h"
#include "loader/old_names.h"

namespace kinome::loader {
namespace {

bool is_lower(char c) {
  return c >= 'a' && c <= 'z';
}
bool is_upper(char c) {
  return c >= 'A' && c <= 'Z';
}

/// "intIOR" -> "int_ior"
std::string snake_case(const std::string& name) {
  std::string result;
  for (size_t i = 0; i < name.size(); ++i) {
    if (i > 0 && is_lower(name[i - 1]) && is_upper(name[i])) result += '_';
    result += is_upper(name[i]) ? static_cast<char>(name[i] - 'A' + 'a') : name[i];
  }
  return result;
}

/// A transform operation from the float children `u` and `v` of a texture, which are removed.
/// Nothing where it has neither.
void take_operation(Node& texture, const char* tag, const char* u, const char* v,
                    std::vector<Node>& operations) {
  Node operation{tag, {}, {}, {}, nullptr};
  for (const auto& [old_name, axis] : {std::pair{u, "x"}, std::pair{v, "y"}}) {
    const auto child =
        std::find_if(texture.children.begin(), texture.children.end(),
                     [&, wanted = old_name](const Node& n) { return n.value("name") == wanted; });
    const Attribute* value = child == texture.children.end() ? nullptr : child->find("value");
    if (!value) continue;
    operation.where = child->where;
    operation.attributes.push_back({axis, value->value, value->where});
    texture.children.erase(child);
  }
  if (!operation.attributes.empty()) operations.push_back(std::move(operation));
}

/// uoffset, voffset, uscale, vscale become to_uv. Mitsuba 3 moves first, then scales.
void upgrade_texture(Node& texture) {
  std::vector<Node> operations;
  take_operation(texture, "translate", "uoffset", "voffset", operations);
  take_operation(texture, "scale", "uscale", "vscale", operations);
  if (operations.empty()) return;
  const Location where = operations.front().where;
  texture.children.push_back(
      {"transform", {{"name", "to_uv", where}}, std::move(operations), where, nullptr});
}

void upgrade_node(Node& node, Faults& faults) {
  Attribute* const name = node.find("name");
  if (name && node.tag != "default") name->value = snake_case(name->value);
  for (Node& child : node.children) upgrade_node(child, faults);
  rename_old(node, faults);
  if (node.tag == "texture") upgrade_texture(node);
  if (node.tag != "bsdf" || node.value("type") != "diffuse") return;
  for (Node& child : node.children) {
    Attribute* const child_name = child.find("name");
    if (child_name && child_name->value == "diffuse_reflectance") child_name->value = "reflectance";
  }
}

int64_t major_version(const Attribute& version) {
  std::array<int64_t, 3> parts{};
  std::string_view rest = version.value;
  for (size_t i = 0; i < parts.size(); ++i) {
    const size_t dot = i == 2 ? rest.size() : rest.find('.');
    const auto part = parse_integer(rest.substr(0, dot));
    if (dot == std::string_view::npos || !part || *part < 0) {
      throw Error(version.where, "'" + version.value + "' is not a version such as '3.0.0'");
    }
    parts[i] = *part;
    rest.remove_prefix(std::min(dot + 1, rest.size()));
  }
  return parts[0];
}

}  // namespace

bool upgrade(Node& root, bool required, Faults& faults) {
  const Attribute* found = root.find("version");
  if (!found) {
    if (!required) return false;
    for (const Attribute& attribute : root.attributes) {
      // That it is none of the root's is told when the root is checked.
      if (!nearest_name(attribute.name, std::array{"version"}).empty()) return false;
    }
    faults.add(root.where, quoted_tag(root) + " needs an attribute 'version', such as '3.0.0'");
    return false;
  }
  const Attribute version = *found;
  root.attributes.erase(root.attributes.begin() + (found - root.attributes.data()));
  bool is_old = false;
  faults.attempt([&] {
    is_old = major_version(version) < 2;
    if (is_old) upgrade_node(root, faults);
  });
  return is_old;
}

}  // namespace kinome::loader
