// Starts to read the files of a scene's objects in parallel.

#include <algorithm>
#include <filesystem>

#include "scene_xml/objects/build.h"

namespace kinome::loader {
namespace {

/// Returns true for objects that other objects only read while they are made, so that several
/// threads may use one.
bool is_shareable(const Node& node) {
  return node.tag == "bsdf" || node.tag == "texture" || node.tag == "spectrum";
}

bool is_file(const Node& child, const PluginDescriptor& plugin) {
  const Parameter* const row = find_row(plugin, child.value("name"));
  return row && row->type == ParameterType::kFile;
}

/// Returns the approximate memory that reading a file takes, the file's own bytes included,
/// relative to the size of the file.
uint64_t memory_per_byte(const std::string& path) {
  struct Kind {
    const char* extension;
    uint64_t factor;
  };
  // Images are decoded to single precision; the smallest files of each kind expand more.
  constexpr Kind kKinds[] = {{".jpg", 32}, {".jpeg", 32}, {".png", 8},
                             {".exr", 4},  {".hdr", 4},   {".serialized", 4}};
  const std::string extension = std::filesystem::path(path).extension().string();
  const auto found = std::find_if(std::begin(kKinds), std::end(kKinds),
                                  [&](const Kind& kind) { return extension == kind.extension; });
  return found == std::end(kKinds) ? 2 : found->factor;
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
    const bool reads = std::any_of(node.children.begin(), node.children.end(),
                                   [&](const Node& child) { return is_file(child, plugin); });
    return reads ? &plugin : nullptr;
  } catch (const Error&) {
    return nullptr;
  }
}

/// Estimates the memory that making an object of its files takes.
uint64_t Builder::memory_to_read(const Node& node, const PluginDescriptor& plugin) {
  uint64_t bytes = 0;
  for (const Node& child : node.children) {
    if (!is_file(child, plugin)) continue;
    const std::string path = file_of(node, child.value("value"));
    std::error_code failed;
    const uint64_t size = std::filesystem::file_size(path, failed);
    if (!failed) bytes += size * memory_per_byte(path);
  }
  return bytes;
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
  constexpr unsigned kMaxThreads = 8;
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
