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
#include "loader/faults.h"

/// The loader's path: text -> nodes (parse) -> nodes without $, default, include, path and alias
/// (expand) -> values and objects, children first (convert, build). Each of them tells Faults of
/// mistakes, and goes on with what it can.
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
  /// Folders of the include files that it comes from, innermost first; set by expand().
  std::shared_ptr<const std::vector<std::string>> folders;
  /// It has a mistake, which is told: what it was to be, and whether some of it can still be looked
  /// at, is uncertain.
  bool is_broken = false;
  /// Parameters that a program sets, in place of what the text says of them.
  std::vector<ObjectDescription::Value> given = {};
  /// Parameters that a program takes away, whatever the text says of them.
  std::vector<std::string> taken = {};
  /// Objects that a program puts in place of values, by their names.
  std::vector<std::shared_ptr<Node>> put = {};
  /// What a program has put this one around, as a bump map is around another BSDF; nullptr:
  /// nothing.
  std::shared_ptr<Node> inner = nullptr;
  /// How transforms among `given` are said, where that isn't by a matrix: their elements.
  std::vector<std::shared_ptr<const Node>> steps = {};
  /// No text says it: a program has put it there.
  bool is_put = false;
  /// From a file whose format is older than 2.0.0.
  bool is_old = false;
  /// `given`, as it was when a program described the object.
  std::vector<ObjectDescription::Value> described = {};

  bool is_given(std::string_view name) const;
  /// Whether what the text says of a parameter doesn't count.
  bool is_overridden(std::string_view name) const;
  const Attribute* find(std::string_view name) const;
  Attribute* find(std::string_view name) {
    return const_cast<Attribute*>(std::as_const(*this).find(name));
  }
  /// Value of an attribute that check_node() has seen, or "".
  std::string value(std::string_view name) const;
};

/// Calls a function with all nodes that stand in one: those of the text, or of a description, and
/// what a program has put there.
template <class Fn>
void for_each_part(const Node& node, const Fn& fn) {
  for (const Node& child : node.children) fn(child);
  for (const auto& put : node.put) fn(*put);
  if (node.inner) fn(*node.inner);
}

/// Whether a node, be it broken, has this attribute, and with the value that was meant.
bool has_certain(const Node& node, std::string_view attribute);
/// "<rgb>" for messages.
std::string quoted_tag(const Node& node);
/// " (did you mean 'x'?)", or "" where there is no such name.
std::string did_you_mean(const std::string& nearest, const std::string& prefix = "");

/// Parses one document into its root. Throws Error for malformed text: after that, nothing is sure.
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
/// Of an unknown tag: kObject.
TagKind kind_of(const Node& node);
/// Checks the tag, its attributes' names and its place inside of `parent` (nullptr: the root);
/// whether all is well.
bool check_node(const Node& node, const Node* parent, Faults& faults);

/// Takes the version off the root and translates files older than 2.0.0: whether it is one.
/// `required`: a mistake where the root has none.
bool upgrade(Node& root, bool required, Faults& faults);

/// A file's nodes with everything textual done.
struct Expansion {
  Node root;
  std::map<std::string, std::string> aliases;  ///< name -> id or alias
  std::vector<std::string> paths;              ///< of <path>, the latest first
  std::string hash;                            ///< of all text and -D, 16 hex digits
  /// Of the scene's file and its includes, by the names that places have; empty: a program said it.
  std::map<std::string, std::string> texts;
  /// What <include> and <path> name: the place of the name, as to_string() has it, to the file or
  /// folder that was found.
  std::map<std::string, std::string> found;
  bool is_of_old_version = false;  ///< some file is older than 2.0.0, and was translated
  /// By mistakes that are told, these ids are of nothing, and there may be others that nobody
  /// knows.
  std::set<std::string> lost_ids;
  bool has_unknown_ids = false;
};
/// `whole_scene`: the root must be a <scene> with a version. Throws Error for malformed text, and
/// where the root is none.
Expansion expand(const std::string& text, const std::string& name, const LoadOptions& options,
                 bool whole_scene, Faults& faults);

/// Replaces Mitsuba's differentiable integrators (`prb` and the like) by those of the same image.
void replace_differentiable(Node& node);

/// The same of a scene file's text, or of what a program says, leniently where that is asked for:
/// what is left out is logged, and goes to `stats`, which may be nullptr.
Expansion expand_scene(const std::string& text, const std::string& name, const LoadOptions& options,
                       bool whole_scene, PluginRegistry& registry, RenderStats* stats,
                       Faults& faults);
/// The nodes of what a program says. `parent`: what it is to stand in; nullptr: nothing.
Node node_of(const ObjectDescription& said, Faults& faults, const Node* parent = nullptr);

/// Returns the scene's folder, those of -a, and kWorkingDirectory unless it is the scene's folder.
std::vector<std::string> base_folders(const std::string& scene_file, const LoadOptions& options);
/// Returns all folders that are searched, in their order: those of the includes that name the file,
/// the innermost first (`includes` may be nullptr); the scene's own; those of <path>; the others of
/// base_folders().
std::vector<std::string> search_folders(const std::vector<std::string>* includes,
                                        const std::vector<std::string>& paths,
                                        const std::vector<std::string>& base);

/// A whole file's text; Error at `where`.
std::string read_text(const std::string& path, const Location& where);

}  // namespace kinome::loader
