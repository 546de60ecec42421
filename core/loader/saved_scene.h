#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "loader/scene_parameters.h"
#include "loader/scene_update.h"

namespace kinome::loader {

/// What an edited scene is to say in a file: for each object, which parameters are not what its
/// text says of them. Arrays (meshes, pixels) are written to files beside the scene's own, and the
/// scene then says the names of those. All that it refers to must outlive it.
class SavedScene {
 public:
  /// `path`: of the scene's file. Writes nothing. Throws Error where a file can't say the edits.
  SavedScene(const Node& root, Builder& builder, const ParameterList& parameters,
             const EditedMeshes& meshes, const std::string& path);

  /// What an object says other than its text.
  struct Said {
    std::string type;  ///< its plugin
    std::vector<ObjectDescription::Value> values;
    std::vector<const Node*> objects;  ///< in place of values: see element()
    std::set<std::string> unsaid;  ///< of the text: what is one of `values` or is left out
  };
  /// nullptr: all is as its text says.
  const Said* find(const Node& node) const;
  const std::map<const Node*, Said>& all() const { return said_; }
  /// Everything that it says, as elements in one line, by their parameters' names.
  std::vector<std::pair<std::string, std::string>> elements(const Node& node) const;
  /// What a program has put into the scene, but for what it put a BSDF around.
  std::string element(const Node& node) const;
  /// What stands in that.
  std::string contents(const Node& node) const;
  const Parameter* row(const Node& node, const std::string& name) const;

  /// A name of a file, as the scene's text or an edit has it, that the saved scene finds, too:
  /// `found` is the file that it named, "" if there was none.
  std::string relocated(const std::string& name, const std::string& found) const;
  /// The same of a value of an object's, where its parameter is a file; otherwise `name`.
  std::string relocated_value(const Node& node, const std::string& parameter,
                              const std::string& name) const;
  /// The same of a file that a <spectrum> names.
  std::string relocated_file(const Node& node, const std::string& name) const {
    return relocated(name, builder_.file_of(node, name));
  }
  /// Of the scene, or of an include, for what follows.
  void set_folder(const std::string& folder) { folder_ = folder; }
  const std::string& folder() const { return folder_; }
  /// Returns the name of a new file beside the saved scene, "STEM-NAME.ending", which no other new
  /// file and no file that was read has. `replaced` is the one file that was read and may be
  /// overwritten, because the saved scene reads the new one in its place; "" for none.
  std::string new_name(const std::string& name, const std::string& ending,
                       const std::string& replaced = "");
  /// All that new_name() has given, to go back to by set_names() after a trial.
  const std::set<std::string>& names() const { return names_; }
  void set_names(std::set<std::string> names) { names_ = std::move(names); }
  /// Writes the files of arrays. Throws Error where they can't be written.
  void write_arrays() const;

 private:
  struct Array {
    std::string path;
    std::string bytes;                    ///< of a mesh's file
    std::shared_ptr<const Image> pixels;  ///< nullptr: a mesh
  };
  void look_at(const Node& node);
  void add(const Node& node);

  Builder& builder_;
  const ParameterList& parameters_;
  const EditedMeshes& meshes_;
  std::string folder_;  ///< with which the names of files begin; "." for the working directory
  std::string stem_;
  std::map<const Node*, std::string> paths_;
  std::map<const Node*, Said> said_;
  std::vector<Array> arrays_;
  std::set<std::string> names_;
};

}  // namespace kinome::loader
