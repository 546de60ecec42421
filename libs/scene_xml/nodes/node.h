#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kinome/error.h"
#include "kinome/object_description.h"
#include "kinome/scene_loader.h"
#include "scene_xml/nodes/faults.h"

/// Stages of the loader: text -> nodes (parse) -> nodes without $, default, include, path and alias
/// (expand) -> values and objects, children first (convert, build). Each stage reports errors to
/// Faults, and continues as far as possible.
namespace kinome::loader {

struct Attribute {
  std::string name;
  std::string value;
  Location where;
};

/// An XML element.
struct Node {
  std::string tag;
  std::vector<Attribute> attributes;
  std::vector<Node> children;
  Location where;
  /// Folders of the include files that contain the node, innermost first; set by expand().
  std::shared_ptr<const std::vector<std::string>> folders;
  /// True if an error was reported for this node; its tag, attributes and children may be wrong.
  bool is_broken = false;
  /// Parameters that a program sets, which override the text.
  std::vector<ObjectDescription::Value> overrides = {};
  /// Names of parameters that a program removes, even if the text has them.
  std::vector<std::string> removed = {};
  /// Objects that a program inserts as values of parameters, with their names.
  std::vector<std::shared_ptr<Node>> inserted = {};
  /// BSDF around which a program has wrapped this one, such as a bump map; nullptr if there is
  /// none.
  std::shared_ptr<Node> inner = nullptr;
  /// <transform> elements for those transforms among `overrides` that aren't written as a matrix.
  std::vector<std::shared_ptr<const Node>> steps = {};
  /// True if a program has inserted the node, so that it isn't in any text.
  bool is_inserted = false;
  /// True if the node is from a file whose format is older than 2.0.0.
  bool is_old = false;
  /// Initial `overrides` of an object that a program has described.
  std::vector<ObjectDescription::Value> described = {};

  bool is_set(std::string_view name) const;
  /// Returns true if a program has set or removed a parameter, so that the text's value is ignored.
  bool is_overridden(std::string_view name) const;
  const Attribute* find(std::string_view name) const;
  Attribute* find(std::string_view name) {
    return const_cast<Attribute*>(std::as_const(*this).find(name));
  }
  /// Returns the value of an attribute, or "" if there is none.
  std::string value(std::string_view name) const;
};

/// Calls a function with all nodes inside of one: those of the text or description, and those that
/// a program has inserted.
template <class Fn>
void for_each_part(const Node& node, const Fn& fn) {
  for (const Node& child : node.children) fn(child);
  for (const auto& inserted : node.inserted) fn(*inserted);
  if (node.inner) fn(*node.inner);
}

/// Calls fn(id, node) for each object of a tree that has an id.
template <class Fn>
void for_each_id(const Node& node, const Fn& fn) {
  if (const Attribute* const id = node.find("id"); id && node.tag != "ref") fn(id->value, node);
  for (const Node& child : node.children) for_each_id(child, fn);
}

/// Tags of objects by their ids.
class IdTags {
 public:
  void collect(const Node& root) {
    for_each_id(root,
                [&](const std::string& id, const Node& node) { tags_.emplace(id, node.tag); });
  }
  /// Returns "" if the id is unknown.
  std::string tag_of(const std::string& id) const {
    const auto found = tags_.find(id);
    return found == tags_.end() ? "" : found->second;
  }

 private:
  std::map<std::string, std::string> tags_;
};

/// Returns true for names of objects without a name, which scenes must not use: "_arg_0".
bool is_reserved_name(std::string_view name);
/// Returns true if a node, even a broken one, has this attribute with a nonempty value without $. A
/// reserved name doesn't count.
bool has_certain(const Node& node, std::string_view attribute);
/// Returns "<rgb>" for messages.
std::string quoted_tag(const Node& node);

/// Parses one document and returns its root. Throws Error for malformed XML.
Node parse(const std::string& text, const std::string& file, Faults& faults);

enum class TagKind {
  kObject,
  kValue,
  kTransform,
  kOperation,
  kRef,
  kAlias,
  kDefault,
  kInclude,
  kPath,
};
bool has_known_tag(const Node& node);
/// Returns kObject for unknown tags.
TagKind kind_of(const Node& node);
/// Checks the tag, the names of its attributes, and whether it may be inside of `parent` (nullptr
/// for the root). Returns false after reporting an error.
bool check_node(const Node& node, const Node* parent, Faults& faults);

/// Removes the version attribute from the root, and translates files older than 2.0.0. Returns true
/// for such files. A missing version is an error if `required`.
bool upgrade(Node& root, bool required, Faults& faults);

/// Nodes of a scene after substitutions, includes and other directives.
struct Expansion {
  Node root;
  std::map<std::string, std::string> aliases;  ///< name -> id or alias
  std::vector<std::string> paths;              ///< folders of <path>, the latest first
  std::string hash;                            ///< hash of all texts and -D, 16 hex digits
  /// Texts of the scene's file and its includes, by file name. Empty for a scene that a program has
  /// described.
  std::map<std::string, std::string> texts;
  /// Files and folders found for <include> and <path>, by the location of the name as to_string()
  /// formats it.
  std::map<std::string, std::string> found;
  bool is_of_old_version = false;  ///< true if a file older than 2.0.0 was translated
  /// Ids that are undefined because of reported errors.
  std::set<std::string> lost_ids;
  bool has_unknown_ids = false;  ///< true if errors may have hidden further ids
};
/// Returns the id that a name stands for.
std::string unaliased(const std::map<std::string, std::string>& aliases, std::string name);
/// Parses and expands a text. If `whole_scene`, the root must be a <scene> with a version. Throws
/// Error for malformed XML and for an invalid root.
Expansion expand(const std::string& text, const std::string& name, const LoadOptions& options,
                 bool whole_scene, Faults& faults);

/// Replaces Mitsuba's differentiable integrators (`prb` and the like) by integrators that render
/// the same image.
void replace_differentiable(Node& node);

/// Expands a text, and replaces differentiable integrators and objects of old files. With
/// LoadOptions::lenient, also leaves out unsupported features, which are logged and listed in
/// `stats` (may be nullptr).
Expansion expand_scene(const std::string& text, const std::string& name, const LoadOptions& options,
                       bool whole_scene, PluginRegistry& registry, RenderStats* stats,
                       Faults& faults);
/// Returns the nodes of an object that a program describes, for use inside of `parent` (may be
/// nullptr).
Node node_of(const ObjectDescription& description, Faults& faults, const Node* parent = nullptr);

/// Returns the scene's folder, those of -a, and kWorkingDirectory unless it is the scene's folder.
std::vector<std::string> base_folders(const std::string& scene_file, const LoadOptions& options);
/// Returns all folders that are searched, in this order: those of the includes that contain the
/// node, the innermost first (`includes` may be nullptr); the scene's own; those of <path>; then
/// the rest of base_folders().
std::vector<std::string> search_folders(const std::vector<std::string>* includes,
                                        const std::vector<std::string>& paths,
                                        const std::vector<std::string>& base);

/// Reads a text file. Throws Error at `where` if that fails.
std::string read_text(const std::string& path, const Location& where);

}  // namespace kinome::loader
