// What is Mitsuba's and isn't here, taken out of a scene.

#include <algorithm>

#include "kinome/log.h"
#include "kinome/mitsuba_plugins.h"
#include "loader/build.h"

namespace kinome::loader {
namespace {

/// What stands in for a plugin of a category, and which of its parameters and parts it keeps.
struct StandIn {
  const char* tag;
  const char* type;
  std::vector<std::string> kept;  ///< names of values, tags of objects
};
const StandIn kStandIns[] = {
    {"bsdf", "diffuse", {}},
    {"integrator", "path", {"max_depth", "rr_depth", "hide_emitters"}},
    {"film",
     "hdrfilm",
     {"width", "height", "crop_offset_x", "crop_offset_y", "crop_width", "crop_height", "rfilter"}},
    {"sampler", "independent", {"sample_count", "seed"}},
    {"rfilter", "gaussian", {}},
    {"sensor", "perspective", {"to_world", "fov", "fov_axis", "film", "sampler"}},
};

class LeavingOut {
 public:
  LeavingOut(const PluginRegistry& registry, std::vector<std::string>& left_out)
      : registry_(registry), left_out_(left_out) {}

  void run(Expansion& expansion) {
    look_at(expansion.root);
    // What names what is gone goes with it, which may be what others name.
    for (size_t before = 0; before != gone_.size();) {
      before = gone_.size();
      for (const auto& [name, target] : expansion.aliases) {
        if (gone_.count(target)) gone_.insert(name);
      }
    }
    if (!gone_.empty()) drop_references(expansion.root);
  }

 private:
  void look_at(Node& node) {
    std::erase_if(node.children, [&](Node& child) {
      if (is_missing(child, registry_)) return !replace(child);
      look_at(child);
      return false;
    });
  }

  /// False where nothing stands in for it.
  bool replace(Node& node) {
    const std::string title = node.tag + " '" + node.value("type") + "'";
    // An integrator around another one shows what that one does.
    if (node.tag == "integrator") {
      const auto inner = std::find_if(node.children.begin(), node.children.end(),
                                      [](const Node& child) { return child.tag == "integrator"; });
      if (inner != node.children.end()) {
        tell(node, title + " (what is nested in it stands in)");
        Node other = std::move(*inner);
        node = std::move(other);
        if (is_missing(node, registry_)) return replace(node);
        look_at(node);
        return true;
      }
    }
    const auto stand_in = std::find_if(std::begin(kStandIns), std::end(kStandIns),
                                       [&](const StandIn& one) { return one.tag == node.tag; });
    if (stand_in == std::end(kStandIns)) {
      tell(node, title);
      note_ids(node);
      return false;
    }
    tell(node, title + " ('" + stand_in->type + "' stands in)");
    node.find("type")->value = stand_in->type;
    std::erase_if(node.children, [&](const Node& child) {
      const auto& kept = stand_in->kept;
      const std::string name = is_object(child) ? child.tag : child.value("name");
      const bool is_kept = std::find(kept.begin(), kept.end(), name) != kept.end();
      if (!is_kept) note_ids(child);
      return !is_kept;
    });
    look_at(node);
    return true;
  }

  void tell(const Node& node, const std::string& what) {
    left_out_.push_back(to_string(node.where) + ": " + what);
  }

  void note_ids(const Node& node) {
    if (node.tag == "ref") return;
    if (const Attribute* id = node.find("id")) gone_.insert(id->value);
    for (const Node& child : node.children) note_ids(child);
  }

  void drop_references(Node& node) {
    std::erase_if(node.children, [&](Node& child) {
      if (child.tag == "ref") return gone_.count(child.value("id")) > 0;
      drop_references(child);
      return false;
    });
  }

  const PluginRegistry& registry_;
  std::vector<std::string>& left_out_;
  std::set<std::string> gone_;  ///< ids
};

}  // namespace

bool is_missing(const Node& node, const PluginRegistry& registry) {
  const Attribute* const type = node.find("type");
  if (node.is_broken || !type || !is_of_mitsuba(node.tag, type->value)) return false;
  const auto category = category_of_tag(node.tag);
  if (!category) return true;
  const auto names = registry.names(*category);
  return std::find(names.begin(), names.end(), type->value) == names.end();
}

Expansion expand_scene(const std::string& text, const std::string& name, const LoadOptions& options,
                       bool whole_scene, PluginRegistry& registry, RenderStats* stats,
                       Faults& faults) {
  Expansion expansion = expand(text, name, options, whole_scene, faults);
  if (options.lenient) {
    std::vector<std::string> left_out;
    LeavingOut(registry, left_out).run(expansion);
    for (const std::string& line : left_out) log_warn(line + " is left out");
    if (stats) stats->left_out = left_out;
  }
  return expansion;
}

}  // namespace kinome::loader
