// Replaces Mitsuba's differentiable integrators by ordinary ones that render the same images.

#include <algorithm>

#include <fmt/format.h>

#include "kinome/log.h"
#include "scene_xml/nodes/node.h"

namespace kinome::loader {
namespace {

struct Primal {
  std::string_view type;
  const char* primal;
  const char* max_depth;  ///< default
};
constexpr Primal kPrimals[] = {
    {"direct_projective", "path", "2"}, {"direct_reparam", "path", "2"},
    {"emission_reparam", "path", "1"},  {"prb", "path", "6"},
    {"prb_basic", "path", "6"},         {"prb_projective", "path", "6"},
    {"prb_reparam", "path", "6"},       {"prbvolpath", "volpath", "6"},
};
constexpr std::string_view kKept[] = {"max_depth", "rr_depth", "hide_emitters"};

}  // namespace

void replace_differentiable(Node& node) {
  for (Node& child : node.children) replace_differentiable(child);
  if (node.tag != "integrator" || node.is_broken) return;
  Attribute* const type = node.find("type");
  if (!type) return;
  const auto found = std::find_if(std::begin(kPrimals), std::end(kPrimals),
                                  [&](const Primal& one) { return one.type == type->value; });
  if (found == std::end(kPrimals)) return;
  log_info(Error(type->where, fmt::format("'{}' is rendered by '{}', whose image is the same",
                                          found->type, found->primal))
               .what());
  type->value = found->primal;
  bool has_depth = false;
  const auto is_dropped = [&](const std::string& name) {
    has_depth |= name == "max_depth";
    return std::find(std::begin(kKept), std::end(kKept), name) == std::end(kKept);
  };
  std::erase_if(node.children, [&](const Node& child) { return is_dropped(child.value("name")); });
  for (auto* const values : {&node.overrides, &node.described}) {
    std::erase_if(*values, [&](const auto& value) { return is_dropped(value.name); });
  }
  if (has_depth) return;
  node.children.push_back(
      {"integer",
       {{"name", "max_depth", node.where}, {"value", found->max_depth, node.where}},
       {},
       node.where,
       nullptr});
}

}  // namespace kinome::loader
