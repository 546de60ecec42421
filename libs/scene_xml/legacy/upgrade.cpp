// Translates scene files of Mitsuba 0.x to those of Mitsuba 3.

#include <algorithm>
#include <array>

#include "base/numbers.h"
#include "scene_xml/legacy/old_names.h"
#include "scene_xml/nodes/node.h"

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

void upgrade_node(Node& node, const Version& version, Faults& faults) {
  node.is_old = true;
  Attribute* const name = node.find("name");
  if (name && node.tag != "default") name->value = snake_case(name->value);
  for (Node& child : node.children) upgrade_node(child, version, faults);
  rename_old(node, version, faults);
}

Version parse_version(const Attribute& version) {
  Version parts{};
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
  return parts;
}

}  // namespace

bool upgrade(Node& root, bool required, Faults& faults) {
  const Attribute* found = root.find("version");
  if (!found) {
    if (!required) return false;
    for (const Attribute& attribute : root.attributes) {
      // A misspelt version is reported when the root is checked.
      if (!nearest_name(attribute.name, std::array{"version"}).empty()) return false;
    }
    faults.add(root.where, quoted_tag(root) + " needs an attribute 'version', such as '3.0.0'");
    return false;
  }
  const Attribute version = *found;
  root.attributes.erase(root.attributes.begin() + (found - root.attributes.data()));
  bool is_old = false;
  faults.attempt([&] {
    const Version parts = parse_version(version);
    is_old = parts[0] < 2;
    if (is_old) upgrade_node(root, parts, faults);
  });
  return is_old;
}

}  // namespace kinome::loader
