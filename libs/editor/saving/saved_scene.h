#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "editor/updates/scene_parameters.h"
#include "editor/updates/scene_update.h"

namespace kinome::loader {

/// Differences between an edited scene and its text, for saving: for each object, the parameters
/// that have changed. Arrays (meshes, pixels) are written to files beside the scene's file, which
/// then refers to them. All constructor arguments must outlive it.
class SavedScene {
 public:
  /// `path` is the file to save to. Writes nothing. Throws Error if a file can't represent the
  /// edits.
  SavedScene(const Node& root, Builder& builder, const ParameterList& parameters,
             const EditedMeshes& meshes, const std::string& path);

  /// Changes of an object against its text.
  struct Changes {
    std::string type;  ///< plugin
    std::vector<ObjectDescription::Value> values;
    std::vector<const Node*> objects;  ///< objects that replace values; see element()
    std::set<std::string> overridden;  ///< names in the text that are replaced or removed
  };
  /// Returns nullptr if the object is unchanged.
  const Changes* find(const Node& node) const;
  const std::map<const Node*, Changes>& all() const { return changes_; }
  /// Returns all changes of an object as XML elements of one line each, with their parameters'
  /// names.
  std::vector<std::pair<std::string, std::string>> elements(const Node& node) const;
  /// Returns the XML element of an object that a program has inserted, without the BSDF of the
  /// scene that it wraps, if any.
  std::string element(const Node& node) const;
  /// Returns the contents of that element.
  std::string contents(const Node& node) const;
  const Parameter* row(const Node& node, const std::string& name) const;

  /// Returns the name by which the saved scene finds a file. `name` is the name in the scene's text
  /// or in an edit, and `found` the file that it referred to, "" if there was none.
  std::string relocated(const std::string& name, const std::string& found) const;
  /// Does the same for the value of a parameter that is a file. Returns `name` for all other
  /// parameters.
  std::string relocated_value(const Node& node, const std::string& parameter,
                              const std::string& name) const;
  /// Does the same for the file of a <spectrum>.
  std::string relocated_file(const Node& node, const std::string& name) const {
    return relocated(name, builder_.file_of(node, name));
  }
  /// Sets the folder of the file that is being written: the scene or an include.
  void set_folder(const std::string& folder) { folder_ = folder; }
  const std::string& folder() const { return folder_; }
  /// Returns the name of a new file beside the saved scene, "STEM-NAME.ending", which no other new
  /// file and no file that was read has. `replaced` is the one file that was read and may be
  /// overwritten, because the saved scene reads the new one in its place; "" for none.
  std::string new_name(const std::string& name, const std::string& ending,
                       const std::string& replaced = "");
  /// Names that new_name() has returned, which set_names() can restore after a trial.
  const std::set<std::string>& names() const { return names_; }
  void set_names(std::set<std::string> names) { names_ = std::move(names); }
  /// Writes the files of arrays. Throws Error on failure.
  void write_arrays() const;

 private:
  struct Array {
    std::string path;
    std::string bytes;                    ///< contents of a file of a mesh or grid
    std::shared_ptr<const Image> pixels;  ///< nullptr otherwise
  };
  void visit(const Node& node);
  void add(const Node& node);
  int slices_of(const Node& node) const;

  Builder& builder_;
  const ParameterList& parameters_;
  const EditedMeshes& meshes_;
  std::string folder_;  ///< prefix of file names; "." for the working directory
  std::string stem_;
  std::map<const Node*, std::string> paths_;
  std::map<const Node*, Changes> changes_;
  std::vector<Array> arrays_;
  std::set<std::string> names_;
};

}  // namespace kinome::loader
