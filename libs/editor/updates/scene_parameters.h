#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor/updates/object_paths.h"
#include "kinome/scene_editor.h"
#include "scene_xml/objects/build.h"

namespace kinome::loader {

/// Parameters of a scene's objects, by path, with their values. `root`, `builder` and `registry`
/// must outlive it.
class ParameterList {
 public:
  ParameterList(Node& root, Builder& builder, PluginRegistry& registry, std::string file)
      : root_(root), builder_(builder), registry_(registry), file_(std::move(file)) {}

  /// Target of an edit: a parameter of an object, or a BSDF itself.
  struct Target {
    Node* node = nullptr;
    const Parameter* row = nullptr;  ///< nullptr for an array of a mesh, and for a BSDF
    std::string name = {};           ///< "" for a BSDF
    bool is_object() const { return name.empty(); }
    bool operator==(const Target& other) const { return node == other.node && name == other.name; }
  };
  std::vector<SceneParameter> all() const;
  /// Returns the parameters whose values are textures.
  std::vector<SceneParameter> textured() const;
  /// Finds a parameter by its path. Throws Error if there is none.
  Target find(const std::string& path) const;
  /// Does the same, but also accepts the path of a BSDF.
  Target find_with_bsdfs(const std::string& path) const;
  /// Returns nullopt if neither the scene nor the plugin's table has a value. Throws Error if the
  /// value is an object.
  std::optional<EditedValue> value(const Target& target) const;
  /// Returns the edit that would restore the current state.
  EditedValue edit_of(const Target& target) const;
  /// Returns the location of the value in the scene, or of its object if the scene has no value.
  static Location where(const Target& target);
  const PluginDescriptor& plugin_of(const Node& node) const;
  /// Returns nullptr if there is no such plugin.
  const PluginDescriptor* known_plugin_of(const Node& node) const;
  /// Returns all objects with their paths.
  const std::vector<ObjectPaths::Entry>& objects() const { return paths().all(); }
  /// Returns the object with a listed path, or nullptr if it is unknown.
  const Node* listed_object(const std::string& path) const { return paths().listed(path); }
  /// Returns the path of an object, or of the shape of which it is a part; "" if there is none.
  std::string path_of(const Object& object) const;
  /// Discards cached paths. Must be called after an update, which may change the objects.
  void forget() { paths_.reset(), paths_of_objects_.clear(); }

 private:
  const ObjectPaths& paths() const;
  std::optional<Target> find_if_any(const std::string& path) const;
  [[noreturn]] void fail(const std::string& path, const std::vector<SceneParameter>& known) const;
  std::vector<const char*> arrays_of(const Node& node) const;
  std::optional<EditedValue> current_value(const Node& node, const Parameter& row) const;
  SceneParameter described(const Node& node, const Parameter& row) const;

  Node& root_;
  Builder& builder_;
  PluginRegistry& registry_;
  std::string file_;
  mutable std::unique_ptr<const ObjectPaths> paths_;  ///< created on first use
  /// Paths of objects and of shapes' parts; empty before the first use.
  mutable std::map<const Object*, std::string> paths_of_objects_;
};

/// Returns the description of an object that a program has inserted.
ObjectDescription described(const Node& node);

/// Returns the <transform> that the scene's text has for a parameter; nullptr if there is none.
const Node* written_transform(const ParameterList::Target& target);
/// Returns true for a plain value, and false for Unset, AsWritten, Placed and object descriptions.
bool is_value(const EditedValue& edited);
/// Converts an edit to a property of its object; returns nullopt for arrays, which aren't
/// properties.
std::optional<Properties::Value> as_property(const EditedValue& edited);

}  // namespace kinome::loader
