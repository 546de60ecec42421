#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "loader/saved_scene.h"
#include "loader/xml_source.h"

namespace kinome::loader {

/// An edited scene as XML: the text that it was read from, with what was edited in place of what
/// stood there, so that comments, order and the form of all else stay. An include that holds edits
/// goes beside the scene, which includes that in its place. What -D said becomes <default>s
/// before all else. All that it refers to must outlive it.
class PatchedScene {
 public:
  /// `name`: the scene's file, as it was read.
  PatchedScene(const Expansion& expansion, const std::string& name,
               const std::map<std::string, std::string>& defines, SavedScene& saved);
  /// The scene's own text. nullopt: the edits can't be said so, as of a file that is included
  /// twice, of an old version, or of what stands in for a plugin that isn't here.
  std::optional<std::string> text();
  /// After text(): the texts of includes that go with it, by their paths.
  const std::map<std::string, std::string>& includes() const { return includes_; }

 private:
  using Patches = std::vector<TextPatch>;
  struct File {
    const std::string& text;
    SourceElement root;
  };
  /// What elements stand in, and which of what it is to say was said.
  struct Owner {
    const Node* node;
    std::set<std::string> said = {};
  };
  void note_places(const Node& node);
  void check(const Node& node);
  const Node* node_at(const Location& where) const;
  const File& file(const std::string& name);
  void patch(const File& file, const SourceElement& element, Owner* owner, Patches& patches);
  void patch_object(const File& file, const SourceElement& element, const Node& node,
                    Patches& patches);
  void patch_values(const File& file, const SourceElement& element, const Node& node,
                    const Owner& own, const SavedScene::Said& said, Patches& patches);
  void patch_children(const File& file, const SourceElement& element, Owner* owner,
                      Patches& patches);
  void patch_around(const File& file, const SourceElement& element, const Node& node,
                    Patches& patches) const;
  bool patch_value(const File& file, const SourceElement& element, const Node& node, Owner& owner,
                   Patches& patches);
  void keep_elsewhere(const File& file, const SourceElement& element, const Node& node);
  void say_expanded(const File& file, const SourceElement& element, Patches& patches);
  void patch_include(const File& file, const SourceElement& element, Owner* owner,
                     Patches& patches);
  std::string included_text(const std::string& path, Owner* owner);
  void insert(const File& file, const SourceElement& element,
              const std::vector<std::string>& elements, Patches& patches) const;

  const Expansion& expansion_;
  const std::string& name_;
  SavedScene& saved_;
  bool is_possible_ = true;
  std::map<std::string, const Node*> nodes_;  ///< by their places
  std::set<std::string> twice_;               ///< places of several nodes
  std::map<const Node*, const Node*> around_;  ///< of BSDFs, what a program has put around them
  std::set<std::string> referred_;            ///< ids
  const std::map<std::string, std::string>& defines_;
  std::map<std::string, File> files_;
  std::vector<std::string> kept_;  ///< elements that are gone from where they stood, for references
  std::map<std::string, std::string> includes_;
};

}  // namespace kinome::loader
