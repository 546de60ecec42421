#pragma once

#include <memory>
#include <string>

#include "check/plan.h"
#include "kinome/plugin_registry.h"
#include "kinome/scene_loader.h"

namespace kinome::check {

/// The plugin that is checked, as scenes name it.
class Subject {
 public:
  /// Error where there is no such plugin, or the request gives it what it can't have.
  explicit Subject(const Request& request);

  Category category() const { return category_; }
  const std::string& name() const { return name_; }
  /// "emitter/constant"
  std::string title() const { return std::string(to_string(category_)) + "/" + name_; }
  const PluginDescriptor& plugin() const { return *plugin_; }
  const Request& request() const { return request_; }
  PluginRegistry& registry() const { return *registry_; }
  int samples(int usual) const;

  /// Its element, with the parameters of the request, each on a line of its own; `changed` is given
  /// another value, which is XML as a whole (see parameter_xml), and `more` is nested in it.
  std::string xml(const std::string& more = "", const std::string& changed = "",
                  const std::string& value_xml = "") const;

  /// The element of --against: its XML, or a plugin of the same category with those parameters of
  /// the request that it has, too.
  std::string xml_against() const;

  template <class T>
  std::shared_ptr<T> make() const {
    return std::dynamic_pointer_cast<T>(
        load_object_from_string(xml(), kFile, {}, *registry_));
  }
  /// The same of another instruction set's plugins.
  template <class T>
  std::shared_ptr<T> make(PluginRegistry& registry) const {
    return std::dynamic_pointer_cast<T>(load_object_from_string(xml(), kFile, {}, registry));
  }
  /// Folders of plugins, for registries of other instruction sets.
  const std::vector<std::string>& folders() const { return folders_; }
  /// A scene of these elements and a camera that sees it from (0, -4, 2.5).
  std::unique_ptr<Scene> scene(const std::string& elements) const;
  /// A scene of these elements alone.
  std::unique_ptr<Scene> scene_of(const std::string& elements) const;

  static constexpr const char* kFile = "check.xml";

  /// Whether the request gives the parameter a value.
  bool is_given(const Parameter& parameter) const;

 private:
  void find(const std::string& wanted);
  void read_against();

  const Request& request_;
  Category category_ = Category::kBsdf;
  std::string name_;
  std::vector<std::string> folders_;
  std::unique_ptr<PluginRegistry> registry_;
  const PluginDescriptor* plugin_ = nullptr;
};

/// A parameter's element for a value that is written as on the command line; one that begins with
/// '<' is the element itself.
std::string parameter_xml(const Parameter& parameter, const std::string& value);
/// What a plugin that needs it is given where the request has no value; "": there is nothing.
std::string needed_xml(const Parameter& parameter);

/// Its construction by default, and by all that may be asked of each parameter.
void add_parameter_checks(const Subject& subject, Plan& plan);
/// Finds parameters that the table declares but the plugin never reads.
void add_read_check(const Subject& subject, Plan& plan);
void add_emitter_checks(const Subject& subject, Plan& plan);
void add_bsdf_checks(const Subject& subject, Plan& plan);
void add_shape_checks(const Subject& subject, Plan& plan);
void add_texture_checks(const Subject& subject, Plan& plan);
void add_sampler_checks(const Subject& subject, Plan& plan);
void add_filter_checks(const Subject& subject, Plan& plan);
void add_sensor_checks(const Subject& subject, Plan& plan);
void add_film_checks(const Subject& subject, Plan& plan);
void add_integrator_checks(const Subject& subject, Plan& plan);

}  // namespace kinome::check
