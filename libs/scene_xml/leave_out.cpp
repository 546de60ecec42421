// Removes or replaces unsupported features of Mitsuba in a scene (--lenient).

#include <algorithm>

#include <fmt/format.h>

#include "base/file_search.h"
#include "kinome/log.h"
#include "kinome/mitsuba_plugins.h"
#include "scene_xml/legacy/legacy.h"
#include "scene_xml/objects/build.h"

namespace kinome::loader {
namespace {

/// Replacement for unsupported plugins of a category, with the parameters and nested objects that
/// are kept.
struct Substitute {
  const char* tag;
  const char* type;
  std::vector<std::string> kept;  ///< names of values, tags of objects
};
const Substitute kSubstitutes[] = {
    {"bsdf", "diffuse", {}},
    {"integrator", "path", {"max_depth", "rr_depth", "hide_emitters"}},
    {"film",
     "hdrfilm",
     {"width", "height", "crop_offset_x", "crop_offset_y", "crop_width", "crop_height", "rfilter"}},
    {"sampler", "independent", {"sample_count", "seed"}},
    {"rfilter", "gaussian", {}},
    {"sensor", "perspective", {"to_world", "fov", "fov_axis", "film", "sampler"}},
};

bool is_registered(const Node& node, const PluginRegistry& registry) {
  const auto category = category_named(node.tag);
  return category && registry.has(*category, node.value("type"));
}

struct LeftOut {
  Location where;
  std::string what;         ///< "integrator 'stokes'"
  std::string replacement;  ///< "'path'", or "" if there is none
};

class UnsupportedRemover {
 public:
  UnsupportedRemover(const PluginRegistry& registry, std::vector<LeftOut>& left_out)
      : registry_(registry), left_out_(left_out) {}

  void run(Expansion& expansion) {
    aliases_ = &expansion.aliases;
    tags_.collect(expansion.root);
    visit(expansion.root);
    // References to removed objects are removed, too, which may remove further objects.
    for (size_t before = 0; before != removed_ids_.size();) {
      before = removed_ids_.size();
      for (const auto& [name, target] : expansion.aliases) {
        if (removed_ids_.count(target)) removed_ids_.insert(name);
      }
      drop_references(expansion.root);
    }
  }

 private:
  /// Returns the tag of an object, or of the object that a reference names; "" if that is unknown.
  std::string tag_of(const Node& node) const {
    return node.tag == "ref" ? tags_.tag_of(target_of(node.value("id"))) : node.tag;
  }
  std::string target_of(const std::string& name) const { return unaliased(*aliases_, name); }
  bool has_part(const Node& node, std::string_view tag) const {
    return std::any_of(node.children.begin(), node.children.end(),
                       [&](const Node& child) { return tag_of(child) == tag; });
  }

  /// Removes the children for which `is_dropped` returns true. Returns false if the node must be
  /// removed, too, because it can't be built without them.
  template <class Fn>
  bool drop_children(Node& node, const Fn& is_dropped) {
    const size_t count = node.children.size();
    std::erase_if(node.children, is_dropped);
    return node.children.size() == count || reduce(node);
  }

  bool visit(Node& node) {
    return drop_children(node, [&](Node& child) {
      return is_unsupported(child) ? !replace(child, node) : !visit(child);
    });
  }
  bool drop_references(Node& node) {
    return drop_children(node, [&](Node& child) {
      if (child.tag == "ref") return removed_ids_.count(child.value("id")) > 0;
      return !drop_references(child);
    });
  }

  /// Repairs a node that lost children. Returns false if it must be removed.
  bool reduce(Node& node) {
    if (node.is_broken || !node.find("type")) return true;
    const std::string type = node.value("type");
    const bool is_bsdf = node.tag == "bsdf";
    if (is_bsdf && type == "bumpmap" && !has_part(node, "texture")) return replace_by_inner(node);
    if (is_bsdf && type == "normalmap" && !legacy::find_child(node, "normalmap")) {
      return replace_by_inner(node);
    }
    if (is_bsdf && type == "blendbsdf" && !legacy::find_child(node, "weight")) {
      add(node, "the weight of " + title_of(node), "0.5");
      legacy::add_number(node, "weight", 0.5);
    }
    const bool is_empty_scale = node.tag == "texture" && type == "scale" &&
                                !legacy::find_child(node, "value") && !has_unnamed_object(node);
    const bool is_empty_instance =
        node.tag == "shape" && (type == "instance" || type == "merge") && !has_unnamed_object(node);
    if (!is_empty_scale && !is_empty_instance) return true;
    add(node, title_of(node), "");
    record_removed_ids(node);
    return false;
  }

  static bool has_unnamed_object(const Node& node) {
    return std::any_of(node.children.begin(), node.children.end(), [](const Node& child) {
      return is_object(child) && child.value("name") != "scale";
    });
  }

  /// Replaces a BSDF by its nested BSDF, which gets its id.
  bool replace_by_inner(Node& node) {
    const auto found = std::find_if(node.children.begin(), node.children.end(),
                                    [&](const Node& child) { return tag_of(child) == "bsdf"; });
    if (found == node.children.end()) return true;
    const Attribute* const id = node.find("id");
    // A BSDF that is nested in itself is reported when it is built.
    if (id && target_of(found->value("id")) == id->value) return true;
    add(node, title_of(node), "the BSDF in it");
    Node inner = std::move(*found);
    if (id && inner.find("id")) {
      aliases_->emplace(id->value, inner.value("id"));
    } else if (id) {
      inner.attributes.push_back(*id);
    }
    std::erase_if(inner.attributes, [](const Attribute& a) { return a.name == "name"; });
    if (const Attribute* const name = node.find("name")) inner.attributes.push_back(*name);
    node = std::move(inner);
    return true;
  }

  static std::string title_of(const Node& node) {
    return node.tag + " '" + node.value("type") + "'";
  }

  /// Replaces an unsupported object. Returns false if there is no substitute, so that it must be
  /// removed.
  bool replace(Node& node, const Node& parent) {
    const std::string title = title_of(node);
    // An integrator with a nested one is replaced by that.
    if (node.tag == "integrator") {
      const auto inner = std::find_if(node.children.begin(), node.children.end(),
                                      [](const Node& child) { return child.tag == "integrator"; });
      if (inner != node.children.end()) {
        add(node, title, "the integrator in it");
        Node other = std::move(*inner);
        node = std::move(other);
        return is_unsupported(node) ? replace(node, parent) : visit(node);
      }
    }
    const auto substitute =
        std::find_if(std::begin(kSubstitutes), std::end(kSubstitutes),
                     [&](const Substitute& one) { return one.tag == node.tag; });
    // A shape can't have a sensor with a position of its own.
    const bool is_in_shape = node.tag == "sensor" && parent.tag == "shape";
    if (substitute == std::end(kSubstitutes) || is_in_shape) {
      add(node, title, "");
      record_removed_ids(node);
      return false;
    }
    add(node, title, fmt::format("'{}'", substitute->type));
    node.find("type")->value = substitute->type;
    std::erase_if(node.children, [&](const Node& child) {
      const auto& kept = substitute->kept;
      const std::string name = is_object(child) ? child.tag : child.value("name");
      const bool is_kept = std::find(kept.begin(), kept.end(), name) != kept.end();
      if (!is_kept) record_removed_ids(child);
      return !is_kept;
    });
    return visit(node);
  }

  void add(const Node& node, const std::string& what, const std::string& replacement) {
    left_out_.push_back({node.where, what, replacement});
  }

  /// Returns true for unsupported plugins. All unknown plugins of old files are unsupported,
  /// because Mitsuba 0.x had more plugins than Mitsuba 3.
  bool is_unsupported(const Node& node) const {
    if (is_missing(node, registry_)) return true;
    if (!node.is_old || node.is_broken || node.tag == "scene" || !node.find("type")) return false;
    return !is_registered(node, registry_);
  }

  void record_removed_ids(const Node& node) {
    if (node.tag == "ref") return;
    if (const Attribute* id = node.find("id")) removed_ids_.insert(id->value);
    for (const Node& child : node.children) record_removed_ids(child);
  }

  const PluginRegistry& registry_;
  std::vector<LeftOut>& left_out_;
  std::set<std::string> removed_ids_;
  IdTags tags_;
  std::map<std::string, std::string>* aliases_ = nullptr;
};

}  // namespace

bool is_missing(const Node& node, const PluginRegistry& registry) {
  const Attribute* const type = node.find("type");
  if (node.is_broken || !type) return false;
  return is_of_mitsuba(node.tag, type->value) && !is_registered(node, registry);
}

Expansion expand_scene(const std::string& text, const std::string& name, const LoadOptions& options,
                       bool whole_scene, PluginRegistry& registry, RenderStats* stats,
                       Faults& faults) {
  Expansion expansion = expand(text, name, options, whole_scene, faults);
  if (expansion.is_of_old_version) {
    const auto find_or_none = [&](const Node& node, const std::string& file) -> std::string {
      try {
        return find_file(
            file, search_folders(node.folders.get(), expansion.paths, base_folders(name, options)),
            node.where);
      } catch (const Error&) {
        return "";  // reported when the object is made
      }
    };
    translate_old(expansion.root, find_or_none, registry, faults);
  }
  replace_differentiable(expansion.root);
  if (options.lenient) {
    std::vector<LeftOut> left_out;
    UnsupportedRemover(registry, left_out).run(expansion);
    for (const LeftOut& one : left_out) {
      const std::string what = to_string(one.where) + ": " + one.what;
      if (one.replacement.empty()) {
        log_warn(fmt::format("{} is left out", what));
        if (stats) stats->left_out.push_back(what);
      } else {
        log_warn(fmt::format("{} is replaced by {}", what, one.replacement));
        if (stats)
          stats->left_out.push_back(fmt::format("{}, replaced by {}", what, one.replacement));
      }
    }
  }
  return expansion;
}

}  // namespace kinome::loader
