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
#include "kinome/scene_loader.h"
#include "kinome/shape_group.h"
#include "kinome/stats.h"
#include "plugin/plugin_check.h"
#include "scene_xml/nodes/node.h"
#include "scene_xml/objects/read_ahead.h"

namespace kinome::loader {

/// Returns true if an object is of an unsupported plugin of Mitsuba.
bool is_missing(const Node& node, const PluginRegistry& registry);
/// Returns why a parameter that Mitsuba accepts for every plugin of a category has no effect here;
/// nullptr if it isn't such a parameter.
const char* why_ignored(Category category, const std::string& name);
/// Returns true for objects, references, failed includes and unknown tags, and false for values.
bool is_object(const Node& node);
/// Returns true for BSDFs, textures and volumes, which are made only if something refers to them,
/// because their files may be large.
bool is_made_on_demand(const Node& node);

/// Maximum nesting of objects, including references. The stack could hold far more.
constexpr size_t kMaxObjectDepth = 500;

/// Builds objects from expanded nodes, children first. `expansion` and `faults` must outlive it.
///
/// BSDFs and textures with errors are replaced by placeholders, so that errors in objects that
/// contain them are found, too. Objects with an invalid parameter are checked but not made.
///
/// With several `threads`, objects that read files are made in parallel. Errors and their order
/// don't depend on it.
class Builder {
 public:
  Builder(const Expansion& expansion, std::vector<std::string> base_folders,
          PluginRegistry& registry, Faults& faults, unsigned threads);

  /// Returns the object of a node (not a <scene>), which is made once. Returns nullptr after
  /// reporting an error.
  std::shared_ptr<Object> object(const Node& node);
  /// Builds everything in a <scene>. The result is complete only if no errors were reported.
  Scene::Contents scene(const Node& root);
  /// "category/name" of all plugins of which objects were made, in the order of their first use.
  const std::vector<std::string>& plugins() const { return plugins_; }
  /// Returns, for each object of the scene, the nodes that contain it or refer to it.
  std::map<const Node*, std::vector<const Node*>> holders() const;
  /// Returns a node itself, or the node that it refers to; nullptr for unknown ids.
  const Node* resolved(const Node& node) const;
  const Node* with_id(const std::string& id) const;
  /// Returns the value of an object's parameter in the scene's text; nullopt if there is none.
  std::optional<Properties::Value> written(const Node& node, const Parameter& row);
  /// Finds the file that a parameter of the node names; "" if there is none.
  std::string file_of(const Node& node, const std::string& name);
  /// Returns the object made of a node; nullptr if there is none.
  std::shared_ptr<Object> made_of(const Node& node) const;
  using Objects = std::unordered_map<const Node*, std::shared_ptr<Object>>;
  const Objects& objects() const { return objects_; }
  /// Replaces the made objects. All others are made again when they are requested.
  void set_objects(Objects objects) { objects_ = std::move(objects); }
  /// Forgets objects of nodes that are no longer part of the scene.
  void forget_gone();
  /// Uses `node` instead of the scene's integrator; nullptr ends this.
  void set_integrator(const Node* node) { integrator_ = node; }
  /// Prepares scenes for denoising, unless nullptr. Call before any object is made.
  void set_denoising(std::shared_ptr<DenoisingSetup> setup) { denoising_ = std::move(setup); }
  /// Returns the objects made since the last call, as "category/name".
  std::vector<std::string> take_made() { return std::exchange(made_, {}); }
  /// Unused BSDFs and textures, which were checked but not made.
  const std::vector<Skipped>& skipped() const { return skipped_; }

 private:
  using Maker = std::function<std::shared_ptr<Object>(const Node&)>;

  /// Properties of an object, and those lost by errors.
  struct Parts {
    Properties props;
    Lost lost;
  };
  /// An object that is made ahead of its turn.
  struct Begun {
    Parts parts;
    ReadAhead::Pending object;
  };
  class UnderConstruction;

  const Node* target_of(const Node& ref);
  void forget_scene();
  void add_overrides(const Node& node, const PluginDescriptor& plugin, Parts& parts);
  std::shared_ptr<Object> make(const Node& node);
  const PluginDescriptor* reader_of(const Node& node);
  void find_readers(const Node& node, size_t depth, std::set<const Node*>& seen,
                    std::vector<const Node*>& readers);
  void begin(const Node& node);
  void begin_readers(const Node& root);
  uint64_t memory_to_read(const Node& node, const PluginDescriptor& plugin);
  const PluginDescriptor* find_plugin(const Node& node);
  void check_parts(const Node& node, const Maker& make);
  Parts read_parts(const Node& node, const PluginDescriptor& plugin, const Maker& make);
  void add_value(const Node& child, const std::string& name, const PluginDescriptor& plugin,
                 Parts& parts);
  void add_object(const Node& child, std::string name, const PluginDescriptor& plugin,
                  const Maker& make, Parts& parts);
  void check_unused(const Node& root);
  void check(const Node& node);
  std::shared_ptr<Object> placeholder(const Node& node);
  std::shared_ptr<Object> create(Properties& props, const Location& type_where,
                                 ReadAhead::Pending* begun = nullptr);
  void warn_of_ignored(const Properties& props, const PluginDescriptor& plugin);
  void warn_once_of_ignored(const Properties& props, const std::string& parameter,
                            const std::string& why, const Location& where);
  void warn_of_dark_emitter(const Shape& shape, const Location& where);
  void add_default_children(Properties& props, const PluginDescriptor& plugin);
  std::shared_ptr<Object> create_film_for_denoising(Properties& props);
  std::shared_ptr<Integrator> with_guides(std::shared_ptr<Integrator> integrator,
                                          const Location& where);
  void add_to_scene(const Node& child, const Node& target, const std::shared_ptr<Object>& object,
                    Scene::Contents& contents);
  void set_parameter(const std::string& name, const Properties::Value& value, const Location& where,
                     Scene::Contents& contents);
  void complete_scene(const Location& where, Scene::Contents& contents);
  void complete_indirect_light(const Location& where, Scene::Contents& contents);
  void add_instances(const std::shared_ptr<Shape>& shape, const Location& where);
  static void warn_of_ignored_media(const Location& where, const Scene::Contents& contents);
  void check_top_emitters();
  void check_instances(const Scene::Contents& contents) const;
  std::shared_ptr<Object> default_object(Category category, const char* plugin,
                                         const Location& where);
  std::shared_ptr<Object> default_sensor(const Location& where, const Scene::Contents& contents);
  std::shared_ptr<const std::vector<std::string>> folders(const Node& node);

  const Expansion& expansion_;
  std::vector<std::string> base_folders_;
  PluginRegistry& registry_;
  Faults& faults_;
  const unsigned threads_;
  std::map<std::string, const Node*> ids_;
  Objects objects_;
  const Node* integrator_ = nullptr;
  std::shared_ptr<DenoisingSetup> denoising_;
  std::vector<std::string> made_;
  std::map<std::string, std::shared_ptr<Object>> defaults_;  ///< default objects, by plugin
  std::set<const Node*> under_construction_;
  std::map<const void*, std::shared_ptr<const std::vector<std::string>>> folder_lists_;
  std::vector<std::string> plugins_;
  int dark_emitters_ = 0;
  std::set<std::string> ignored_;  ///< "category 'plugin': parameter" for each warning
  std::set<const Node*> checked_;  ///< unused objects, which aren't made
  std::set<const Node*> referenced_by_unused_;
  std::set<const Object*> in_scene_;
  /// With their locations, for checks after all shapes are made.
  std::vector<std::pair<std::shared_ptr<Emitter>, Location>> top_emitters_;
  std::vector<std::pair<std::shared_ptr<const ShapeInstance>, Location>> instances_;
  /// Emitters of surfaces, each with the warning that it gets if no shape refers to it.
  std::vector<std::pair<std::shared_ptr<Emitter>, Error>> surface_emitters_;
  std::map<std::string, Location> parameters_;  ///< locations of the scene's own parameters
  std::vector<Skipped> skipped_;
  std::map<const Node*, Begun> begun_;
  std::unique_ptr<ReadAhead> ahead_;  ///< destroyed before begun_, which its threads use
};

/// Returns a BSDF that reflects nothing, for emitting shapes without a BSDF.
std::shared_ptr<Bsdf> make_black_bsdf();

}  // namespace kinome::loader
