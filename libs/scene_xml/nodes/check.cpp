// Known tags and their attributes, and which tags may be nested.

#include <algorithm>
#include <array>

#include "base/numbers.h"
#include "scene_xml/nodes/node.h"

namespace kinome::loader {
namespace {

struct TagRule {
  std::string_view tag;
  TagKind kind;
  std::string_view required;  ///< attributes, separated by spaces
  std::string_view optional;
};

constexpr std::array kRules{
    TagRule{"scene", TagKind::kObject, "", "type id name"},
    TagRule{"bsdf", TagKind::kObject, "type", "id name"},
    TagRule{"emitter", TagKind::kObject, "type", "id name"},
    TagRule{"film", TagKind::kObject, "type", "id name"},
    TagRule{"integrator", TagKind::kObject, "type", "id name"},
    TagRule{"medium", TagKind::kObject, "type", "id name"},
    TagRule{"phase", TagKind::kObject, "type", "id name"},
    TagRule{"rfilter", TagKind::kObject, "type", "id name"},
    TagRule{"sampler", TagKind::kObject, "type", "id name"},
    TagRule{"sensor", TagKind::kObject, "type", "id name"},
    TagRule{"shape", TagKind::kObject, "type", "id name"},
    TagRule{"texture", TagKind::kObject, "type", "id name"},
    TagRule{"volume", TagKind::kObject, "type", "id name"},
    TagRule{"float", TagKind::kValue, "name value", ""},
    TagRule{"integer", TagKind::kValue, "name value", ""},
    TagRule{"boolean", TagKind::kValue, "name value", ""},
    TagRule{"string", TagKind::kValue, "name value", ""},
    TagRule{"rgb", TagKind::kValue, "name value", ""},
    TagRule{"point", TagKind::kValue, "name", "value x y z"},
    TagRule{"vector", TagKind::kValue, "name", "value x y z"},
    TagRule{"spectrum", TagKind::kValue, "name", "value filename"},
    TagRule{"transform", TagKind::kTransform, "name", ""},
    TagRule{"translate", TagKind::kOperation, "", "value x y z"},
    TagRule{"scale", TagKind::kOperation, "", "value x y z"},
    TagRule{"rotate", TagKind::kOperation, "angle", "value x y z"},
    TagRule{"lookat", TagKind::kOperation, "origin target", "up"},
    TagRule{"matrix", TagKind::kOperation, "value", ""},
    TagRule{"ref", TagKind::kRef, "id", "name"},
    TagRule{"alias", TagKind::kAlias, "id as", ""},
    TagRule{"default", TagKind::kDefault, "name value", ""},
    TagRule{"include", TagKind::kInclude, "filename", ""},
    TagRule{"path", TagKind::kPath, "value", ""},
};

const TagRule* find_rule(const std::string& tag) {
  const auto found = std::find_if(kRules.begin(), kRules.end(),
                                  [&](const TagRule& rule) { return rule.tag == tag; });
  return found == kRules.end() ? nullptr : &*found;
}

void add_unknown_tag(const Node& node, Faults& faults) {
  std::vector<std::string_view> tags;
  for (const TagRule& rule : kRules) tags.push_back(rule.tag);
  faults.add(node.where,
             "unknown tag " + quoted_tag(node) + did_you_mean(nearest_name(node.tag, tags)));
}

/// Checks the names of attributes. Returns false after reporting an error.
bool check_attributes(const Node& node, const TagRule& rule, Faults& faults) {
  const std::vector<std::string_view> required = split_list(rule.required);
  std::vector<std::string_view> known = required;
  for (const std::string_view name : split_list(rule.optional)) known.push_back(name);
  std::vector<std::string_view> meant = known;
  meant.push_back("version");  // already removed from the root
  bool is_fine = true;
  for (const Attribute& attribute : node.attributes) {
    if (std::find(known.begin(), known.end(), attribute.name) == known.end()) {
      faults.add(attribute.where, quoted_tag(node) + " has no attribute '" + attribute.name + "'" +
                                      did_you_mean(nearest_name(attribute.name, meant)));
    } else if (node.find(attribute.name) != &attribute) {
      faults.add(attribute.where, "attribute '" + attribute.name + "' is given twice");
    } else {
      continue;
    }
    is_fine = false;
  }
  // An unknown attribute may be a misspelt required one.
  if (!is_fine) return false;
  for (const std::string_view name : required) {
    if (node.find(name)) continue;
    faults.add(node.where, quoted_tag(node) + " needs an attribute '" + std::string(name) + "'");
    is_fine = false;
  }
  return is_fine;
}

/// Returns true if an empty attribute counts as absent: objects need neither name nor id.
bool may_be_empty(TagKind kind, std::string_view attribute) {
  if (kind == TagKind::kRef) return attribute == "name";
  return kind == TagKind::kObject;
}

/// Checks names and ids, which must not be empty or reserved for objects without a name. Returns
/// false after reporting an error.
bool check_names(const Node& node, TagKind kind, Faults& faults) {
  bool is_fine = true;
  for (const char* name : {"name", "id", "as"}) {
    const Attribute* attribute = node.find(name);
    if (!attribute) continue;
    const std::string& value = attribute->value;
    if (attribute->name == "name" && is_reserved_name(value)) {
      faults.add(attribute->where, "'" + value +
                                       "': names that begin with _arg_ or _default_ are "
                                       "reserved");
    } else if (value.empty() && !may_be_empty(kind, name)) {
      faults.add(attribute->where, std::string(name) + " is empty");
    } else {
      continue;
    }
    is_fine = false;
  }
  return is_fine;
}

bool may_contain(const Node& parent, TagKind kind) {
  const TagRule* rule = find_rule(parent.tag);
  if (!rule) return true;  // an unknown tag
  if (rule->kind == TagKind::kTransform) return kind == TagKind::kOperation;
  return rule->kind == TagKind::kObject && kind != TagKind::kOperation;
}

}  // namespace

bool has_known_tag(const Node& node) {
  return find_rule(node.tag) != nullptr;
}

TagKind kind_of(const Node& node) {
  const TagRule* rule = find_rule(node.tag);
  return rule ? rule->kind : TagKind::kObject;
}

bool check_node(const Node& node, const Node* parent, Faults& faults) {
  const TagRule* rule = find_rule(node.tag);
  if (!rule) {
    add_unknown_tag(node, faults);
    return false;
  }
  if (!parent && rule->kind != TagKind::kObject) {
    faults.stop(
        Error(node.where, "the root must be an object such as <scene>, not " + quoted_tag(node)));
  }
  if (parent && (node.tag == "scene" || !may_contain(*parent, rule->kind))) {
    faults.add(node.where, quoted_tag(node) + " can't be inside " + quoted_tag(*parent));
    return false;
  }
  const bool has_attributes = check_attributes(node, *rule, faults);
  return check_names(node, rule->kind, faults) && has_attributes;
}

}  // namespace kinome::loader
