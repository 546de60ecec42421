#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "scene_xml/nodes/node.h"

/// Translation of objects from files of Mitsuba 0.x, after substitution and includes. (Names and
/// tags are translated before, in old_names.cpp.) Sources: the manual of Mitsuba 0.6 for
/// parameters, defaults and axes; its upgrade rules for files older than 0.5.
namespace kinome::loader::legacy {

/// Returns the path of a file that a node names; "" if it isn't found.
using FileFinder = std::function<std::string(const Node& node, const std::string& name)>;

/// Reports warnings, each message once: scenes repeat their materials.
class Warnings {
 public:
  void add(const Location& where, const std::string& message);

 private:
  std::set<std::string> reported_;
};

/// Returns the first child of this name; nullptr if there is none.
Node* find_child(Node& node, std::string_view name);
/// Returns the value of a child of this name; "" if there is none.
std::string child_value(const Node& node, std::string_view name);
/// Removes the first child of this name and returns it; nullopt if there is none.
std::optional<Node> take_child(Node& node, std::string_view name);
void remove_children(Node& node, std::string_view name);
/// Renames a parameter, unless the node has one of the new name.
void rename_child(Node& node, std::string_view old_name, const std::string& new_name);
/// Appends a value tag such as <float name="…" value="…"/>.
void add_value(Node& node, const std::string& tag, const std::string& name,
               const std::string& value);
void add_number(Node& node, const std::string& name, double value);
void set_type(Node& node, const std::string& type);
/// Returns an object of a plugin without parameters.
Node make_object(const std::string& tag, const std::string& type, const Location& where);
/// Returns the number of a child; `fallback` if there is none, or if it isn't a number, which is
/// reported when the object's parameters are read.
double number_of(const Node& node, std::string_view name, double fallback);

void translate_integrator(Node& node, Warnings& warnings);
void translate_film(Node& node, Warnings& warnings);
void translate_sensor(Node& node, Warnings& warnings);
void translate_emitter(Node& node, Warnings& warnings);
void translate_bsdf(Node& node, Warnings& warnings, Faults& faults);
void translate_texture(Node& node, Warnings& warnings);
void translate_medium(Node& node, Warnings& warnings);
void translate_volume(Node& node);

/// Replaces `vertexcolors` by black in shapes without colours, as in Mitsuba 0.6. Must come before
/// textures are translated.
void translate_vertex_colors(Node& root, const FileFinder& find_file, Warnings& warnings);
/// Replaces ambient occlusion, which is an integrator of Mitsuba 0.6, by direct light on a white
/// scene under a white sky.
void translate_ambient_occlusion(Node& scene, Warnings& warnings);

}  // namespace kinome::loader::legacy

namespace kinome::loader {

/// Translates the objects that come from old files.
void translate_old(Node& root, const legacy::FileFinder& find_file, PluginRegistry& registry,
                   Faults& faults);

}  // namespace kinome::loader
