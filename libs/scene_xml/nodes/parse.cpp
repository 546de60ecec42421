// Parses a scene file into nodes with line and column.

#include <algorithm>

#include <pugixml.hpp>

#include "kinome/log.h"
#include "scene_xml/nodes/node.h"
#include "scene_xml/nodes/source_locations.h"
#include "scene_xml/nodes/unclosed.h"

namespace kinome::loader {
namespace {

/// Maximum nesting of elements in a file, which limits recursion.
constexpr int kMaxNesting = 100;

class Converter {
 public:
  Converter(const std::string& text, const std::string& file, Faults& faults)
      : text_(text), locations_(text, file), faults_(faults) {}

  Node convert(const pugi::xml_node& element, int depth) {
    Node node;
    node.tag = element.name();
    const auto name_offset = static_cast<size_t>(element.offset_debug());
    node.where = locations_.at(name_offset - 1);
    read_attributes(element, name_offset + node.tag.size(), node);
    // As in Mitsuba 3, a <spectrum> with a type is a texture.
    if (node.tag == "spectrum" && node.find("type")) node.tag = "texture";
    if (depth > kMaxNesting) {
      faults_.add(node.where, "elements are nested too deeply");
      node.is_broken = true;  // so that missing children aren't reported
      return node;
    }
    for (const pugi::xml_node& child : element.children()) {
      if (child.type() == pugi::node_element) {
        node.children.push_back(convert(child, depth + 1));
      } else {
        warn_of_text(node, child.value());
      }
    }
    return node;
  }

 private:
  /// Finds the locations of attributes, which pugixml doesn't store. It has checked the syntax.
  void read_attributes(const pugi::xml_node& element, size_t offset, Node& node) {
    for (const pugi::xml_attribute& attribute : element.attributes()) {
      offset = text_.find_first_not_of(" \t\r\n", offset);
      node.attributes.push_back({attribute.name(), attribute.value(), locations_.at(offset)});
      const size_t quote = text_.find_first_of("\"'", offset);
      offset = text_.find(text_[quote], quote + 1) + 1;
    }
  }

  /// Text has no meaning in a scene, and Mitsuba ignores it. Blanks need no warning.
  static void warn_of_text(const Node& node, const std::string& text) {
    constexpr size_t kMaxLength = 40;
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) return;
    log_warn(Error(node.where, "text inside " + quoted_tag(node) + " is ignored: '" +
                                   text.substr(0, kMaxLength) + "'")
                 .what());
  }

  const std::string& text_;
  SourceLocations locations_;
  Faults& faults_;
};

/// Names the element that lacks its end tag, if that is what is wrong at `offset`.
std::string describe_syntax(const pugi::xml_parse_result& result, const std::string& text,
                            const std::string& file, size_t offset) {
  const std::string message = std::string("malformed XML: ") + result.description();
  if (result.status != pugi::status_end_element_mismatch) return message;
  const auto open = innermost_open_element(text, offset);
  if (!open) return message;
  const int line = SourceLocations(text, file).at(open->begin).line;
  return message + ": <" + open->tag + "> in line " + std::to_string(line) + " isn't closed";
}

}  // namespace

bool Node::is_set(std::string_view name) const {
  for (const ObjectDescription::Value& value : overrides) {
    if (value.name == name) return true;
  }
  return false;
}

bool Node::is_overridden(std::string_view name) const {
  return is_set(name) || std::find(removed.begin(), removed.end(), name) != removed.end();
}

const Attribute* Node::find(std::string_view name) const {
  for (const Attribute& attribute : attributes) {
    if (attribute.name == name) return &attribute;
  }
  return nullptr;
}

std::string Node::value(std::string_view name) const {
  const Attribute* attribute = find(name);
  return attribute ? attribute->value : "";
}

bool is_reserved_name(std::string_view name) {
  return name.starts_with("_arg_") || name.starts_with("_default_");
}

bool has_certain(const Node& node, std::string_view attribute) {
  const Attribute* const found = node.find(attribute);
  return found && !found->value.empty() && found->value.find('$') == std::string::npos &&
         !(attribute == "name" && is_reserved_name(found->value));
}

std::string quoted_tag(const Node& node) {
  return "<" + node.tag + ">";
}

Node parse(const std::string& text, const std::string& file, Faults& faults) {
  if (const size_t nul = text.find('\0'); nul != std::string::npos) {
    throw Error(SourceLocations(text, file).at(nul), "malformed XML: a zero byte");
  }
  // Parsed as a fragment, which keeps text outside of the root.
  constexpr unsigned kFlags = pugi::parse_default | pugi::parse_fragment;
  pugi::xml_document document;
  const pugi::xml_parse_result result =
      document.load_buffer(text.data(), text.size(), kFlags, pugi::encoding_utf8);
  if (!result) {
    const size_t offset = result.offset > 0 ? static_cast<size_t>(result.offset) : 0;
    throw Error(SourceLocations(text, file).at(offset),
                describe_syntax(result, text, file, offset));
  }
  const pugi::xml_node root = document.document_element();
  for (const pugi::xml_node& node : document.children()) {
    const bool is_element = node.type() == pugi::node_element;
    if (node == root) continue;
    const auto offset = static_cast<size_t>(node.offset_debug());
    throw Error(SourceLocations(text, file)
                    .at(is_element ? offset - 1 : text.find_first_not_of(" \t\r\n", offset)),
                is_element ? "malformed XML: a second root element"
                           : "malformed XML: text outside of the root element");
  }
  if (!root) throw Error(SourceLocations(text, file).at(0), "malformed XML: no element");
  return Converter(text, file, faults).convert(root, 1);
}

}  // namespace kinome::loader
