// Translates all objects of old files.

#include <algorithm>
#include <cctype>
#include <optional>

#include <fmt/format.h>

#include "kinome/plugin_registry.h"
#include "scene_xml/legacy/legacy.h"
#include "scene_xml/objects/build.h"

namespace kinome::loader {
namespace {

using namespace legacy;

/// Parameters of Mitsuba 0.x that don't change an image, by their object's tag.
constexpr std::pair<std::string_view, std::string_view> kWithoutEffect[] = {
    {"integrator", "strict_normals"},
    {"film", "banner"},
    {"film", "attach_log"},
    {"sensor", "map_smaller_side"},
    {"sampler", "scramble"},
    {"sampler", "dimension"},
    {"sampler", "depth"},
    {"shape", "max_smooth_angle"},
    {"shape", "collapse"},
    {"shape", "srgb"},
    {"texture", "cache"},
    {"texture", "max_anisotropy"},
    {"emitter", "cache"},
    {"emitter", "gamma"},
    {"bsdf", "specular_sampling_weight"},
    {"bsdf", "ext_eta"},
};

class Translation {
 public:
  Translation(PluginRegistry& registry, Faults& faults) : registry_(registry), faults_(faults) {}

  void run(Node& node, const FileFinder& find_file) {
    translate_vertex_colors(node, find_file, warnings_);
    if (node.tag == "scene") tags_.collect(node);
    translate(node);
  }

 private:
  /// Returns the tag of an object, or of the object that a reference names; "" if that is unknown.
  std::string tag_of(const Node& node) const {
    return node.tag == "ref" ? tags_.tag_of(node.value("id")) : node.tag;
  }

  void translate(Node& node) {
    if (node.tag == "scene") {
      if (node.is_old) translate_scene(node);
    } else if (node.is_old && !node.is_broken && node.find("type")) {
      translate_object(node);
    }
    for (Node& child : node.children) translate(child);
  }

  void translate_scene(Node& scene) {
    translate_ambient_occlusion(scene, warnings_);
    std::erase_if(scene.children, [&](const Node& child) {
      const bool is_value =
          child.is_old && !child.is_broken &&
          (kind_of(child) == TagKind::kValue || kind_of(child) == TagKind::kTransform);
      if (is_value) {
        warnings_.add(child.where,
                      fmt::format("'{}' of the scene is ignored", child.value("name")));
      }
      return is_value;
    });
  }

  void translate_object(Node& node) {
    keep_last_values(node);
    if (node.tag == "integrator") translate_integrator(node, warnings_);
    if (node.tag == "film") translate_film(node, warnings_);
    if (node.tag == "sensor") translate_sensor(node, warnings_);
    if (node.tag == "emitter") translate_emitter(node, warnings_);
    if (node.tag == "bsdf") translate_bsdf(node, warnings_, faults_);
    if (node.tag == "texture") translate_texture(node, warnings_);
    if (node.tag == "medium") translate_medium(node, warnings_);
    if (node.tag == "volume") translate_volume(node);
    if (node.tag == "sampler" && node.value("type") == "hammersley") set_type(node, "ldsampler");
    if (node.tag == "shape") translate_shape(node);
    restore_capitals(node);
    drop_unused(node);
  }

  /// Restores capital letters of parameters that have some, such as B of `mitchell`. They were
  /// lost when names were translated to snake case.
  void restore_capitals(Node& node) {
    const auto category = category_named(node.tag);
    const auto* const plugin = category ? find_plugin(*category, *node.find("type")) : nullptr;
    if (!plugin) return;
    for (const Parameter& row : plugin->parameters) {
      std::string lower = row.name;
      for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (lower != row.name && !find_row(*plugin, lower)) rename_child(node, lower, row.name);
    }
  }

  /// Renames parameters from before 0.3, and keeps one BSDF of an OBJ file's, as Mitsuba 3
  /// requires. Boundaries of media without a BSDF are invisible.
  void translate_shape(Node& node) {
    const std::string type = node.value("type");
    if (type == "sphere") rename_child(node, "inverted", "flip_normals");
    if (type == "cylinder" && find_child(node, "p2")) {
      rename_child(node, "p1", "p0");
      rename_child(node, "p2", "p1");
    }
    bool has_bsdf = false;
    std::erase_if(node.children, [&](const Node& child) {
      if (tag_of(child) != "bsdf" || !std::exchange(has_bsdf, true)) return false;
      warnings_.add(child.where, "the first BSDF is used for the whole shape");
      return true;
    });
    const bool has_medium = find_child(node, "interior") || find_child(node, "exterior");
    const bool has_light = std::ranges::any_of(node.children, [&](const Node& child) {
      return tag_of(child) == "emitter" || tag_of(child) == "sensor";
    });
    if (has_medium && !has_bsdf && !has_light) {
      node.children.push_back(make_object("bsdf", "null", node.where));
    }
  }

  /// Keeps the last value of a parameter that is given several times, as Mitsuba 0.6 did.
  void keep_last_values(Node& node) {
    std::set<std::string> seen;
    for (size_t i = node.children.size(); i-- > 0;) {
      const Node& child = node.children[i];
      const std::string name = child.value("name");
      if (name.empty() || kind_of(child) != TagKind::kValue || seen.insert(name).second) continue;
      warnings_.add(child.where,
                    fmt::format("'{}' is given twice, and the last value is used", name));
      node.children.erase(node.children.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  /// Removes parameters that a plugin doesn't have, with a warning as in Mitsuba 0.x.
  void drop_unused(Node& node) {
    const auto category = category_named(node.tag);
    if (!category) return;
    const PluginDescriptor* const plugin = find_plugin(*category, *node.find("type"));
    std::erase_if(node.children, [&](const Node& child) {
      const TagKind kind = kind_of(child);
      const std::string name = child.value("name");
      const bool is_map = node.tag == "bsdf" && !name.empty() && tag_of(child) == "texture";
      if (kind != TagKind::kValue && kind != TagKind::kTransform && !is_map) return false;
      if (is_without_effect(node, name)) return true;
      if (!plugin || child.is_broken || find_row(*plugin, name)) return false;
      if (is_map && takes_any_texture(*plugin)) return false;
      if (why_ignored(*category, name)) return false;
      warnings_.add(child.where, unused_message(node, *plugin, name));
      return true;
    });
  }

  /// Returns nullptr if the plugin is unknown. Searches for each plugin once.
  const PluginDescriptor* find_plugin(Category category, const Attribute& type) {
    const auto entry = plugins_.emplace(std::pair(category, type.value), nullptr);
    const PluginDescriptor*& found = entry.first->second;
    if (!entry.second) return found;
    if (registry_.has(category, type.value)) {
      faults_.attempt([&] { found = &registry_.find(category, type.value, type.where); });
    }
    return found;
  }

  static bool takes_any_texture(const PluginDescriptor& plugin) {
    return std::any_of(plugin.parameters.begin(), plugin.parameters.end(), [](const auto& row) {
      return row.type == ParameterType::kObject && row.category == Category::kTexture &&
             !row.by_name;
    });
  }

  static bool is_without_effect(const Node& node, const std::string& name) {
    return std::any_of(std::begin(kWithoutEffect), std::end(kWithoutEffect), [&](const auto& one) {
      return node.tag == one.first && name == one.second;
    });
  }

  static std::string unused_message(const Node& node, const PluginDescriptor& plugin,
                                    const std::string& name) {
    std::vector<std::string> known;
    for (const Parameter& row : plugin.parameters) known.emplace_back(row.name);
    return fmt::format("{} '{}' has no parameter '{}', which is ignored{}", node.tag,
                       node.value("type"), name, did_you_mean(nearest_name(name, known)));
  }

  PluginRegistry& registry_;
  Faults& faults_;
  Warnings warnings_;
  IdTags tags_;
  std::map<std::pair<Category, std::string>, const PluginDescriptor*> plugins_;
};

}  // namespace

void translate_old(Node& root, const legacy::FileFinder& find_file, PluginRegistry& registry,
                   Faults& faults) {
  Translation(registry, faults).run(root, find_file);
}

}  // namespace kinome::loader
