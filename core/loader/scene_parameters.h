#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinome/scene_editor.h"
#include "loader/build.h"
#include "loader/object_paths.h"

namespace kinome::loader {

/// Which parameters a scene's objects have, by their paths, and what their values are. `root`,
/// `builder` and `registry` must outlive it.
class ParameterList {
 public:
  ParameterList(Node& root, Builder& builder, PluginRegistry& registry, std::string file)
      : root_(root), builder_(builder), registry_(registry), file_(std::move(file)) {}

  /// A parameter of an object, or a BSDF itself.
  struct Place {
    Node* node = nullptr;
    const Parameter* row = nullptr;  ///< nullptr: an array of a mesh, or the BSDF
    std::string name = {};           ///< "": the BSDF
    bool is_object() const { return name.empty(); }
    bool operator==(const Place& other) const { return node == other.node && name == other.name; }
  };
  std::vector<SceneParameter> all() const;
  /// Those that textures stand for.
  std::vector<SceneParameter> textured() const;
  /// Error where there is none of this path.
  Place find(const std::string& path) const;
  /// The same, but that a path may be that of a BSDF, too.
  Place find_with_bsdfs(const std::string& path) const;
  /// nullopt: neither the scene nor the plugin's table says any. Error where it is an object.
  std::optional<EditedValue> value(const Place& place) const;
  /// What an edit is that makes it what it is.
  EditedValue edit_of(const Place& place) const;
  /// Where the scene says what it is, or would say it.
  static Location where(const Place& place);
  const PluginDescriptor& plugin_of(const Node& node) const;
  /// nullptr: there is none of its name.
  const PluginDescriptor* known_plugin_of(const Node& node) const;
  /// All objects, with their paths.
  const std::vector<ObjectPaths::Place>& objects() const { return paths().all(); }
  /// After an update, which may have changed what objects there are.
  void forget() { paths_.reset(); }

 private:
  const ObjectPaths& paths() const;
  std::optional<Place> look_for(const std::string& path) const;
  [[noreturn]] void fail(const std::string& path, const std::vector<SceneParameter>& known) const;
  std::vector<const char*> arrays_of(const Node& node) const;
  std::optional<EditedValue> said(const Node& node, const Parameter& row) const;
  SceneParameter described(const Node& node, const Parameter& row) const;

  Node& root_;
  Builder& builder_;
  PluginRegistry& registry_;
  std::string file_;
  mutable std::unique_ptr<const ObjectPaths> paths_;  ///< made when first asked for
};

/// What a node says that a program has put there; `name`: of the parameter that it is of.
ObjectDescription described(const Node& node);

/// What the scene's text says of a transform; nullptr: nothing.
const Node* written_transform(const ParameterList::Place& place);
/// Rather than what is set in place of a value.
bool is_value(const EditedValue& edited);
/// What an edit is to the object that it is of; nullopt: an array, which is none of these.
std::optional<Properties::Value> as_property(const EditedValue& edited);

}  // namespace kinome::loader
