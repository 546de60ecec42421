#pragma once

#include <memory>
#include <string>

#include "kit/plan.h"
#include "kinome/error.h"
#include "kinome/plugin_registry.h"
#include "kinome/scene_loader.h"

namespace kinome::check {

/// The checked plugin, and its XML element for scenes.
class Subject {
 public:
  /// Throws Error if the plugin doesn't exist, or the request gives it invalid parameters.
  explicit Subject(const Request& request);

  Category category() const { return category_; }
  const std::string& name() const { return name_; }
  /// "emitter/constant"
  std::string title() const { return std::string(to_string(category_)) + "/" + name_; }
  const PluginDescriptor& plugin() const { return *plugin_; }
  const Request& request() const { return request_; }
  PluginRegistry& registry() const { return *registry_; }
  /// Returns the number of samples for the request's effort; `usual` is that for effort 1.
  int samples(int usual) const;

  /// Returns the plugin's XML element with the parameters of the request, each on a line of its
  /// own. The parameter `changed` is replaced by the element `value_xml` (see parameter_xml()), and
  /// the elements `more` are appended.
  std::string xml(const std::string& more = "", const std::string& changed = "",
                  const std::string& value_xml = "") const;

  /// Returns the element of --against: its XML, or a plugin of the same category with those
  /// parameters of the request that it also has.
  std::string xml_against() const;

  /// Returns the object of an XML element.
  std::shared_ptr<Object> load(const std::string& element) const {
    return load_object_from_string(element, kFile, {}, *registry_);
  }
  template <class T>
  std::shared_ptr<T> make() const {
    return std::dynamic_pointer_cast<T>(load(xml()));
  }
  /// The same with the plugins of another registry, for another instruction set.
  template <class T>
  std::shared_ptr<T> make(PluginRegistry& registry) const {
    return std::dynamic_pointer_cast<T>(load_object_from_string(xml(), kFile, {}, registry));
  }
  /// Folders of plugins, for registries of other instruction sets.
  const std::vector<std::string>& folders() const { return folders_; }
  /// Returns a scene with these elements, the integrator `direct`, and a camera at (0, -4, 2.5).
  std::unique_ptr<Scene> scene(const std::string& elements) const;
  /// Returns a scene with these elements only.
  std::unique_ptr<Scene> scene_of(const std::string& elements) const;

  static constexpr const char* kFile = "check.xml";

  /// Returns true if the request gives the parameter a value.
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

/// How values of a type are written in XML, and values to try.
struct TypeValues {
  const char* tag = "";              ///< kFloatOrName and colours: the tag of single numbers
  const char* needed = "";           ///< for a required parameter without a value; "": unknown
  std::vector<std::string> usual;    ///< those most likely to be accepted first
  std::vector<std::string> extreme;  ///< the plugin may accept or refuse these
  std::vector<std::string> invalid;  ///< the plugin must refuse these
};
/// Has no values for kImage and kObject.
TypeValues values_of(ParameterType type);

/// Returns a parameter's XML element for a value as written on the command line. A value that
/// starts with '<' is the element itself.
std::string parameter_xml(const Parameter& parameter, const std::string& value);
/// Returns the XML element for a required parameter without a value in the request; "" if there is
/// no suitable value.
std::string needed_xml(const Parameter& parameter);

/// Returns true if the plugin can be created with the parameters of the request. Throws Error if
/// they are invalid, which is a fault of the command line, not of the plugin.
bool can_be_created(const Subject& subject);
/// Returns true if the error stands for a plugin's exception that isn't a kinome::Error.
inline bool is_foreign_exception(const Error& error) {
  return error.message().starts_with("plugin '");
}

/// Returns the elements of a scene that uses the plugin of this XML element, for the camera of
/// Subject::scene(). Returns "" for categories that aren't checked in a scene.
std::string surroundings(const Subject& subject, const std::string& xml);

/// Checks with audit_plugins(), at many points of a scene, whether the plugin's functions agree
/// with one another. Reports only faults for which `wanted` returns true.
Outcome audit(const Subject& subject, const std::function<bool(const std::string&)>& wanted);

/// Checks the creation of the plugin with default values, and with extreme and invalid ones.
void add_parameter_checks(const Subject& subject, Plan& plan);
/// Finds parameters that the table declares but the plugin never reads.
void add_read_check(const Subject& subject, Plan& plan);
void add_emitter_checks(const Subject& subject, Plan& plan);
/// Parts of add_emitter_checks(): the light that leaves an emitter, along rays and as light points;
/// the light at a receiver by sample_emission() and by sample_direct(); the origins of emitted rays
/// and the distances of sampled light; a comparison with another emitter, if the request names one.
void add_emission_checks(const Subject& subject, Plan& plan);
void add_irradiance_checks(const Subject& subject, Plan& plan);
void add_origin_checks(const Subject& subject, Plan& plan);
void add_against_check(const Subject& subject, Plan& plan);
void add_bsdf_checks(const Subject& subject, Plan& plan);
void add_shape_checks(const Subject& subject, Plan& plan);
void add_texture_checks(const Subject& subject, Plan& plan);
void add_volume_checks(const Subject& subject, Plan& plan);
void add_phase_checks(const Subject& subject, Plan& plan);
void add_medium_checks(const Subject& subject, Plan& plan);
void add_sampler_checks(const Subject& subject, Plan& plan);
void add_filter_checks(const Subject& subject, Plan& plan);
void add_sensor_checks(const Subject& subject, Plan& plan);
void add_film_checks(const Subject& subject, Plan& plan);
void add_integrator_checks(const Subject& subject, Plan& plan);

}  // namespace kinome::check
