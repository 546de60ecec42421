#include "scene_xml/legacy/legacy.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/numbers.h"
#include "kinome/log.h"

namespace kinome::loader::legacy {
namespace {

auto position_of(Node& node, std::string_view name) {
  return std::find_if(node.children.begin(), node.children.end(),
                      [&](const Node& child) { return child.value("name") == name; });
}

}  // namespace

void Warnings::add(const Location& where, const std::string& message) {
  if (reported_.insert(message).second) log_warn(Error(where, message).what());
}

Node* find_child(Node& node, std::string_view name) {
  const auto found = position_of(node, name);
  return found == node.children.end() ? nullptr : &*found;
}

std::string child_value(const Node& node, std::string_view name) {
  const Node* const child = find_child(const_cast<Node&>(node), name);
  return child ? child->value("value") : "";
}

std::optional<Node> take_child(Node& node, std::string_view name) {
  const auto found = position_of(node, name);
  if (found == node.children.end()) return std::nullopt;
  Node child = std::move(*found);
  node.children.erase(found);
  return child;
}

void remove_children(Node& node, std::string_view name) {
  std::erase_if(node.children, [&](const Node& child) { return child.value("name") == name; });
}

void rename_child(Node& node, std::string_view old_name, const std::string& new_name) {
  Node* const child = find_child(node, old_name);
  if (child && !find_child(node, new_name)) child->find("name")->value = new_name;
}

void add_value(Node& node, const std::string& tag, const std::string& name,
               const std::string& value) {
  node.children.push_back(
      {tag, {{"name", name, node.where}, {"value", value, node.where}}, {}, node.where, nullptr});
}

void add_number(Node& node, const std::string& name, double value) {
  add_value(node, "float", name, fmt::format("{:.9g}", value));
}

void set_type(Node& node, const std::string& type) {
  node.find("type")->value = type;
}

Node make_object(const std::string& tag, const std::string& type, const Location& where) {
  return {tag, {{"type", type, where}}, {}, where, nullptr};
}

double number_of(const Node& node, std::string_view name, double fallback) {
  return parse_real(child_value(node, name)).value_or(fallback);
}

}  // namespace kinome::loader::legacy
