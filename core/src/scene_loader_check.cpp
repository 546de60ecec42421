#include <algorithm>
#include <array>

#include "numbers.h"
#include "scene_loader_node.h"

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

const TagRule& rule_of(const Node& node) {
  if (const TagRule* rule = find_rule(node.tag)) return *rule;
  std::vector<std::string_view> tags;
  for (const TagRule& rule : kRules) tags.push_back(rule.tag);
  throw Error(node.where,
              "unknown tag " + quoted_tag(node) + did_you_mean(nearest_name(node.tag, tags)));
}

void check_attributes(const Node& node, const TagRule& rule) {
  std::vector<std::string_view> known = split_list(rule.required);
  for (const std::string_view name : known) {
    if (node.find(name)) continue;
    throw Error(node.where, quoted_tag(node) + " needs an attribute '" + std::string(name) + "'");
  }
  for (const std::string_view name : split_list(rule.optional)) known.push_back(name);
  if (const Attribute* type = node.tag == "spectrum" ? node.find("type") : nullptr) {
    throw Error(type->where,
                "spectra of a type, such as '" + type->value +
                    "', are not supported: give the colour as <rgb>, or the values by wavelength, "
                    "as <spectrum value=\"400:1, 700:2\"/> or filename");
  }
  for (const Attribute& attribute : node.attributes) {
    if (std::find(known.begin(), known.end(), attribute.name) == known.end()) {
      throw Error(attribute.where, quoted_tag(node) + " has no attribute '" + attribute.name + "'" +
                                       did_you_mean(nearest_name(attribute.name, known)));
    }
    if (node.find(attribute.name) != &attribute) {
      throw Error(attribute.where, "attribute '" + attribute.name + "' is given twice");
    }
  }
}

bool may_contain(const Node& parent, TagKind kind) {
  const TagRule* rule = find_rule(parent.tag);
  const TagKind outer = rule ? rule->kind : TagKind::kObject;
  if (outer == TagKind::kTransform) return kind == TagKind::kOperation;
  return outer == TagKind::kObject && kind != TagKind::kOperation;
}

}  // namespace

TagKind check_node(const Node& node, const Node* parent) {
  const TagRule& rule = rule_of(node);
  if (!parent && rule.kind != TagKind::kObject) {
    throw Error(node.where, "the root must be an object such as <scene>, not " + quoted_tag(node));
  }
  if (parent && (node.tag == "scene" || !may_contain(*parent, rule.kind))) {
    throw Error(node.where, quoted_tag(node) + " can't stand inside " + quoted_tag(*parent));
  }
  check_attributes(node, rule);
  for (const char* name : {"name", "id", "as"}) {
    const Attribute* attribute = node.find(name);
    if (!attribute) continue;
    if (attribute->value.empty()) throw Error(attribute->where, std::string(name) + " is empty");
    if (attribute->value[0] == '_') {
      throw Error(attribute->where, "'" + attribute->value +
                                        "': names that begin with an "
                                        "underscore are reserved");
    }
  }
  return rule.kind;
}

}  // namespace kinome::loader
