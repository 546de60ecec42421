// Starts to read the files of a scene's objects in parallel.

#include <algorithm>

#include "scene_xml/build.h"

namespace kinome::loader {
namespace {

/// Returns true for objects that other objects only read while they are made, so that several
/// threads may use one.
bool is_shareable(const Node& node) {
  return node.tag == "bsdf" || node.tag == "texture" || node.tag == "spectrum";
}

}  // namespace

/// Returns the plugin of a node whose object would be read from a file; nullptr for other objects,
/// objects that were made, and objects with errors, which are reported when it is their turn.
const PluginDescriptor* Builder::reader_of(const Node& node) {
  const auto category = category_named(node.tag);
  const Attribute* const type = node.find("type");
  // Sensors and films get default objects in their turn.
  if (category == Category::kSensor || category == Category::kFilm) return nullptr;
  if (!category || !type || node.is_broken || objects_.count(&node)) return nullptr;
  try {
    const PluginDescriptor& plugin = registry_.find(*category, type->value, type->where);
    const auto is_file = [&](const Node& child) {
      const Parameter* const row = find_row(plugin, child.value("name"));
      return row && row->type == ParameterType::kFile;
    };
    return std::any_of(node.children.begin(), node.children.end(), is_file) ? &plugin : nullptr;
  } catch (const Error&) {
    return nullptr;
  }
}

/// Finds the readers among a node and the objects that it contains or refers to, those first.
void Builder::find_readers(const Node& node, size_t depth, std::set<const Node*>& seen,
                           std::vector<const Node*>& readers) {
  const Node* const target = resolved(node);
  if (!target || depth > kMaxObjectDepth || !seen.insert(target).second) return;
  const bool is_replaced = integrator_ && target->tag == "integrator";
  if (is_replaced || objects_.count(target) || is_missing(*target, registry_)) return;
  for_each_part(*target, [&](const Node& part) {
    const bool is_used = is_object(part) && !target->is_overridden(part.value("name"));
    if (is_used) find_readers(part, depth + 1, seen, readers);
  });
  if (reader_of(*target)) readers.push_back(target);
}

/// Begins to make the objects of a scene that read files. Objects that read no file are made in
/// their turn.
void Builder::begin_readers(const Node& root) {
  std::vector<const Node*> readers;
  std::set<const Node*> seen;
  for (const Node& child : root.children) {
    if (is_object(child) && !is_made_on_demand(child)) find_readers(child, 0, seen, readers);
  }
  if (readers.size() < 2) return;
  // A single thread takes the same steps, so that the order of messages and plugins is the same.
  constexpr unsigned kMaxThreads = 8;  // each holds the bytes of a file
  ahead_ = std::make_unique<ReadAhead>(threads_ > 1 ? std::min(threads_, kMaxThreads) : 0);
  // Readers without nested objects come first, because the others wait for them.
  const auto has_objects = [](const Node* node) {
    bool any = false;
    for_each_part(*node, [&](const Node& part) { any |= is_object(part); });
    return any;
  };
  std::stable_partition(readers.begin(), readers.end(),
                        [&](const Node* node) { return !has_objects(node); });
  for (const Node* const node : readers) {
    bool is_begun = true;
    for_each_part(*node, [&](const Node& part) {
      const Node* const target = is_object(part) ? resolved(part) : nullptr;
      is_begun &= !is_object(part) || (target && is_shareable(*target));
    });
    if (is_begun) begin(*node);
  }
}

}  // namespace kinome::loader
