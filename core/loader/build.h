#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "kinome/scene.h"
#include "kinome/shape_group.h"
#include "kinome/stats.h"
#include "loader/node.h"
#include "plugin/plugin_check.h"

namespace kinome::loader {

/// The category of objects that a tag is of; nullopt: none that there is.
std::optional<Category> category_of_tag(const std::string& tag);
/// Whether an object is of a plugin of Mitsuba's that isn't here.
bool is_missing(const Node& node, const PluginRegistry& registry);
/// Returns why a parameter that Mitsuba accepts for every plugin of a category has no effect here;
/// nullptr if it isn't such a parameter.
const char* why_ignored(Category category, const std::string& name);
/// Rather than a value: objects, references to them, and what may have been meant as one.
bool is_object(const Node& node);
/// Made only where something refers to them: their files may be large.
bool is_made_on_demand(const Node& node);

/// Makes objects from expanded nodes, children first. `expansion` and `faults` must outlive it.
///
/// Where a BSDF or texture has a mistake, another stands in for it, so that mistakes in what it is
/// part of are found, too; where a parameter has one, its object is checked and not made.
class Builder {
 public:
  Builder(const Expansion& expansion, std::vector<std::string> base_folders,
          PluginRegistry& registry, Faults& faults);

  /// The object of a node (not a <scene>); made once, however often it is referred to. nullptr: it
  /// has a mistake, which is told.
  std::shared_ptr<Object> object(const Node& node);
  /// Everything in a <scene>; whole only if no faults are told.
  Scene::Contents scene(const Node& root);
  /// "category/name" of the plugins that objects were made of, in order, each once.
  const std::vector<std::string>& plugins() const { return plugins_; }
  /// What an object of the scene is part of, and where it is referred to.
  std::map<const Node*, std::vector<const Node*>> holders() const;
  /// What a node is, or refers to; nullptr: nothing that is known.
  const Node* resolved(const Node& node) const;
  const Node* with_id(const std::string& id) const;
  /// The value that the scene's text gives to an object's parameter; nullopt: none.
  std::optional<Properties::Value> written(const Node& node, const Parameter& row);
  /// The file that a parameter of the node names; "": none is found.
  std::string file_of(const Node& node, const std::string& name);
  /// What was made of a node; nullptr: nothing was.
  std::shared_ptr<Object> made_of(const Node& node) const;
  using Objects = std::unordered_map<const Node*, std::shared_ptr<Object>>;
  const Objects& objects() const { return objects_; }
  /// Goes back, or forgets: what isn't among these is made when it is next asked for.
  void set_objects(Objects objects) { objects_ = std::move(objects); }
  /// Forgets what was made of nodes that are no more part of the scene.
  void forget_gone();
  /// In place of the scene's integrator, whatever that is.
  void set_integrator(const Node* node) { integrator_ = node; }
  /// Those made since this was called last, as "category/name".
  std::vector<std::string> take_made() { return std::exchange(made_, {}); }
  /// BSDFs and textures of the scene that were checked, but not made.
  const std::vector<Skipped>& skipped() const { return skipped_; }

 private:
  using Maker = std::function<std::shared_ptr<Object>(const Node&)>;

  /// What the scene says of an object.
  struct Parts {
    Properties props;
    Lost lost;
  };
  class UnderWay;

  void collect_ids(const Node& node);
  const Node* target_of(const Node& ref);
  std::string unaliased(std::string id) const;
  void forget_scene();
  void add_given(const Node& node, const PluginDescriptor& plugin, Parts& parts);
  std::shared_ptr<Object> make(const Node& node);
  const PluginDescriptor* find_plugin(const Node& node);
  void look_at_parts(const Node& node, const Maker& make);
  Parts read_parts(const Node& node, const PluginDescriptor& plugin, const Maker& make);
  void add_value(const Node& child, const std::string& name, const PluginDescriptor& plugin,
                 Parts& parts);
  void add_object(const Node& child, std::string name, const PluginDescriptor& plugin,
                  const Maker& make, Parts& parts);
  void check_unused(const Node& root);
  void check(const Node& node);
  std::shared_ptr<Object> stand_in(const Node& node);
  std::shared_ptr<Object> create(Properties& props, const Location& type_where);
  void warn_of_ignored(const Properties& props, const PluginDescriptor& plugin);
  void warn_once_of_ignored(const Properties& props, const std::string& parameter,
                            const std::string& why, const Location& where);
  void warn_of_dark_lamp(const Shape& shape, const Location& where);
  void add_default_children(Properties& props, const PluginDescriptor& plugin);
  void add_to_scene(const Node& child, const Node& target, const std::shared_ptr<Object>& object,
                    Scene::Contents& contents);
  void set_parameter(const std::string& name, const Properties::Value& value, const Location& where,
                     Scene::Contents& contents);
  void complete_scene(const Location& where, Scene::Contents& contents);
  void complete_indirect_light(const Location& where, Scene::Contents& contents);
  void add_instances(const std::shared_ptr<Shape>& shape, const Location& where);
  void check_instances(const Scene::Contents& contents) const;
  std::shared_ptr<Object> default_object(Category category, const char* plugin,
                                         const Location& where);
  std::shared_ptr<Object> default_sensor(const Location& where, const Scene::Contents& contents);
  std::shared_ptr<const std::vector<std::string>> folders(const Node& node);

  const Expansion& expansion_;
  std::vector<std::string> base_folders_;
  PluginRegistry& registry_;
  Faults& faults_;
  std::map<std::string, const Node*> ids_;
  Objects objects_;
  const Node* integrator_ = nullptr;
  std::vector<std::string> made_;
  /// What a scene is given that has none of its own, by its plugin: of all that are made.
  std::map<std::string, std::shared_ptr<Object>> defaults_;
  std::set<const Node*> under_way_;
  std::map<const void*, std::shared_ptr<const std::vector<std::string>>> folder_lists_;
  std::vector<std::string> plugins_;
  int dark_lamps_ = 0;
  std::set<std::string> ignored_;  ///< "category 'plugin': parameter", of those with a warning
  std::set<const Node*> checked_;  ///< of what isn't made
  std::set<const Node*> named_by_unused_;
  std::set<const Object*> in_scene_;
  /// With their places, for what is known of them only when all shapes are made.
  std::vector<std::pair<std::shared_ptr<Emitter>, Location>> top_emitters_;
  std::vector<std::pair<std::shared_ptr<const ShapeInstance>, Location>> instances_;
  /// Emitters of surfaces, each with the warning that it gets if no shape refers to it.
  std::vector<std::pair<std::shared_ptr<Emitter>, Error>> surface_emitters_;
  std::map<std::string, Location> parameters_;  ///< of the scene itself
  std::vector<Skipped> skipped_;
};

/// The BSDF of a shape that emits but has none of its own: it reflects nothing.
std::shared_ptr<Bsdf> make_black_bsdf();

}  // namespace kinome::loader
