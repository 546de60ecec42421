// What is Mitsuba's and isn't here, taken out of a scene.

#include <algorithm>

#include <fmt/format.h>

#include "base/file_search.h"
#include "kinome/log.h"
#include "kinome/mitsuba_plugins.h"
#include "loader/build.h"
#include "loader/legacy/legacy.h"

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

bool is_registered(const Node& node, const PluginRegistry& registry) {
  const auto category = category_of_tag(node.tag);
  if (!category) return false;
  const auto names = registry.names(*category);
  return std::find(names.begin(), names.end(), node.value("type")) != names.end();
}

struct LeftOut {
  Location where;
  std::string what;         ///< "integrator 'stokes'"
  std::string replacement;  ///< "'path'"; "": none
};

class LeavingOut {
 public:
  LeavingOut(const PluginRegistry& registry, std::vector<LeftOut>& left_out)
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
      if (must_go(child)) return !replace(child);
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
        add(node, title, "the integrator in it");
        Node other = std::move(*inner);
        node = std::move(other);
        if (must_go(node)) return replace(node);
        look_at(node);
        return true;
      }
    }
    const auto stand_in = std::find_if(std::begin(kStandIns), std::end(kStandIns),
                                       [&](const StandIn& one) { return one.tag == node.tag; });
    if (stand_in == std::end(kStandIns)) {
      add(node, title, "");
      note_ids(node);
      return false;
    }
    add(node, title, fmt::format("'{}'", stand_in->type));
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

  void add(const Node& node, const std::string& what, const std::string& replacement) {
    left_out_.push_back({node.where, what, replacement});
  }

  /// Unknown plugins of old files go, too: there were more of them than Mitsuba 3 has.
  bool must_go(const Node& node) const {
    if (is_missing(node, registry_)) return true;
    if (!node.is_old || node.is_broken || node.tag == "scene" || !node.find("type")) return false;
    return !is_registered(node, registry_);
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
  std::vector<LeftOut>& left_out_;
  std::set<std::string> gone_;  ///< ids
};

}  // namespace

bool is_missing(const Node& node, const PluginRegistry& registry) {
  const Attribute* const type = node.find("type");
  if (node.is_broken || !type) return false;
  constexpr std::string_view kAbsent[] = {"medium", "phase", "volume"};
  if (std::find(std::begin(kAbsent), std::end(kAbsent), node.tag) != std::end(kAbsent)) return true;
  return is_of_mitsuba(node.tag, type->value) && !is_registered(node, registry);
}

Expansion expand_scene(const std::string& text, const std::string& name, const LoadOptions& options,
                       bool whole_scene, PluginRegistry& registry, RenderStats* stats,
                       Faults& faults) {
  Expansion expansion = expand(text, name, options, whole_scene, faults);
  if (expansion.is_of_old_version) {
    const auto find_or_none = [&](const Node& node, const std::string& file) -> std::string {
      try {
        return find_file(file,
                         search_folders(node.folders.get(), expansion.paths,
                                        base_folders(name, options)),
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
    LeavingOut(registry, left_out).run(expansion);
    for (const LeftOut& one : left_out) {
      const std::string what = to_string(one.where) + ": " + one.what;
      if (one.replacement.empty()) {
        log_warn(fmt::format("{} is left out", what));
        if (stats) stats->left_out.push_back(what);
      } else {
        log_warn(fmt::format("{} is replaced by {}", what, one.replacement));
        if (stats) stats->left_out.push_back(fmt::format("{}, replaced by {}", what, one.replacement));
      }
    }
  }
  return expansion;
}

}  // namespace kinome::loader
