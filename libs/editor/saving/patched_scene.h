#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "editor/saving/saved_scene.h"
#include "editor/saving/xml_source.h"

namespace kinome::loader {

/// Saves an edited scene as XML by patching its original text, which keeps comments, order and
/// formatting. An include that changes is saved beside the scene, which includes the new file
/// instead. Values of -D become <default>s at the beginning. All constructor arguments must outlive
/// it.
class PatchedScene {
 public:
  /// `name` is the file from which the scene was read.
  PatchedScene(const Expansion& expansion, const std::string& name,
               const std::map<std::string, std::string>& defines, SavedScene& saved);
  /// Returns the text of the scene's file, or nullopt if the edits can't be written as patches.
  /// Reasons are a file that is included twice or has an old version, and the replacement of an
  /// unsupported plugin.
  std::optional<std::string> text();
  /// Texts of the changed includes, by path; valid after text().
  const std::map<std::string, std::string>& includes() const { return includes_; }

 private:
  using Patches = std::vector<TextPatch>;
  struct File {
    const std::string& text;
    SourceElement root;
  };
  /// Object that contains the visited elements, and the names of its values that are already
  /// written.
  struct Owner {
    const Node* node;
    std::set<std::string> written = {};
  };
  void note_locations(const Node& node);
  void check(const Node& node);
  const Node* node_at(const Location& where) const;
  const File& file(const std::string& name);
  void patch(const File& file, const SourceElement& element, Owner* owner, Patches& patches);
  void patch_object(const File& file, const SourceElement& element, const Node& node,
                    Patches& patches);
  void patch_values(const File& file, const SourceElement& element, const Node& node,
                    const Owner& own, const SavedScene::Changes& changes, Patches& patches);
  void patch_children(const File& file, const SourceElement& element, Owner* owner,
                      Patches& patches);
  void patch_wrapper(const File& file, const SourceElement& element, const Node& node,
                     Patches& patches) const;
  bool patch_value(const File& file, const SourceElement& element, const Node& node, Owner& owner,
                   Patches& patches);
  void keep_elsewhere(const File& file, const SourceElement& element, const Node& node);
  void expand_names(const File& file, const SourceElement& element, Patches& patches);
  void patch_include(const File& file, const SourceElement& element, Owner* owner,
                     Patches& patches);
  std::string included_text(const std::string& path, Owner* owner);
  void insert(const File& file, const SourceElement& element,
              const std::vector<std::string>& elements, Patches& patches) const;

  const Expansion& expansion_;
  const std::string& name_;
  SavedScene& saved_;
  bool is_possible_ = true;
  std::map<std::string, const Node*> nodes_;     ///< by location
  std::set<std::string> ambiguous_;              ///< locations of several nodes
  std::map<const Node*, const Node*> wrappers_;  ///< from a BSDF to the BSDF wrapped around it
  std::set<std::string> referenced_ids_;         ///< ids that references name
  const std::map<std::string, std::string>& defines_;
  std::map<std::string, File> files_;
  std::vector<std::string>
      kept_;  ///< elements moved to the beginning, because of references to them
  std::map<std::string, std::string> includes_;
};

}  // namespace kinome::loader
