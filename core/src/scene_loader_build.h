#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "kinome/scene.h"
#include "kinome/stats.h"
#include "scene_loader_node.h"

namespace kinome::loader {

/// Makes objects from expanded nodes, children first. `expansion` must outlive it.
class Builder {
 public:
  Builder(const Expansion& expansion, std::vector<std::string> base_folders,
          PluginRegistry& registry);

  /// The object of a node (not a <scene>); made once, however often it is referred to.
  std::shared_ptr<Object> object(const Node& node);
  /// Everything in a <scene>.
  Scene::Contents scene(const Node& root);
  /// "category/name" of the plugins that objects were made of, in order, each once.
  const std::vector<std::string>& plugins() const { return plugins_; }
  /// BSDFs and textures of the scene that were checked, but not made.
  const std::vector<Skipped>& skipped() const { return skipped_; }

 private:
  using Maker = std::function<std::shared_ptr<Object>(const Node&)>;

  void collect_ids(const Node& node);
  const Node& target_of(const Node& ref) const;
  Properties start_properties(const Node& node, Category category);
  void check_unused(const Node& root);
  void check(const Node& node);
  std::shared_ptr<Object> stand_in(const Node& node);
  std::shared_ptr<Object> create(Properties& props, const Location& type_where);
  void warn_of_dark_lamp(const Shape& shape, const Location& where);
  void add_child(const Node& child, Properties& props, int& unnamed, const Maker& make);
  void add_default_children(Properties& props, const PluginDescriptor& plugin);
  void add_to_scene(const Node& child, const std::shared_ptr<Object>& object,
                    Scene::Contents& contents);
  void complete_scene(const Location& where, Scene::Contents& contents);
  void complete_indirect_light(const Location& where, Scene::Contents& contents);
  std::shared_ptr<Object> default_sensor(const Location& where, const Scene::Contents& contents);
  std::shared_ptr<const std::vector<std::string>> folders(const Node& node);

  const Expansion& expansion_;
  std::vector<std::string> base_folders_;
  PluginRegistry& registry_;
  std::map<std::string, const Node*> ids_;
  std::unordered_map<const Node*, std::shared_ptr<Object>> objects_;
  std::set<const Node*> under_way_;
  std::map<const void*, std::shared_ptr<const std::vector<std::string>>> folder_lists_;
  std::vector<std::string> plugins_;
  int dark_lamps_ = 0;
  std::set<const Node*> checked_;  ///< of what isn't made
  std::set<const Node*> named_by_unused_;
  std::set<const Object*> in_scene_;
  /// With their places, for what is known of them only when all shapes are made.
  std::vector<std::pair<std::shared_ptr<Emitter>, Location>> top_emitters_;
  std::vector<Skipped> skipped_;
};

/// The BSDF of a shape that emits but has none of its own: it reflects nothing.
std::shared_ptr<Bsdf> make_black_bsdf();

}  // namespace kinome::loader
