// Patches the text of a scene's files with edits.

#include "editor/saving/patched_scene.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "base/file_search.h"
#include "editor/saving/written_values.h"

namespace kinome::loader {
namespace {

namespace fs = std::filesystem;

void collect_references(const Node& node, std::set<std::string>& ids,
                        const std::map<std::string, std::string>& aliases) {
  if (node.tag == "ref") ids.insert(unaliased(aliases, node.value("id")));
  for_each_part(node, [&](const Node& child) { collect_references(child, ids, aliases); });
}

bool holds_one_of(const Node& node, const std::set<std::string>& ids) {
  if (node.tag == "ref") return false;
  if (ids.count(node.value("id"))) return true;
  for (const Node& child : node.children) {
    if (holds_one_of(child, ids)) return true;
  }
  return false;
}

/// Returns a patch that removes an element. If the element begins a line, the patch also removes
/// the line break and the indentation before it.
TextPatch removal(const std::string& text, size_t begin, size_t end) {
  if (!begins_line(text, begin)) return {begin, end, ""};
  const size_t before = begin == 0 ? std::string::npos : text.find_last_not_of(" \t", begin - 1);
  return {before == std::string::npos ? 0 : before, end, ""};
}

TextPatch replacement(const SourceElement::Attribute& attribute, const std::string& value) {
  return {attribute.value_begin, attribute.value_end, attribute_text(value, attribute.where)};
}

bool is_within(const SourceElement::Attribute& attribute, const std::vector<TextPatch>& patches) {
  return std::any_of(patches.begin(), patches.end(), [&](const TextPatch& patch) {
    return patch.begin < attribute.value_end && patch.end > attribute.value_begin;
  });
}

}  // namespace

PatchedScene::PatchedScene(const Expansion& expansion, const std::string& name,
                           const std::map<std::string, std::string>& defines, SavedScene& saved)
    : expansion_(expansion), name_(name), saved_(saved), defines_(defines) {
  is_possible_ = !expansion.texts.empty() && !expansion.is_of_old_version;
  if (!is_possible_) return;
  note_locations(expansion.root);
  collect_references(expansion.root, referenced_ids_, expansion.aliases);
  for (const auto& [node, changes] : saved.all()) check(*node);
}

void PatchedScene::note_locations(const Node& node) {
  const std::string location = to_string(node.where);
  if (!node.is_inserted && !nodes_.emplace(location, &node).second) ambiguous_.insert(location);
  if (node.inner) wrappers_[node.inner.get()] = &node;
  for_each_part(node, [this](const Node& child) { note_locations(child); });
}

/// Checks whether a changed object and its values each have a unique location in the text.
void PatchedScene::check(const Node& node) {
  if (node.is_inserted) return;
  bool is_there_once = !ambiguous_.count(to_string(node.where));
  for (const Node& child : node.children) {
    is_there_once &= !ambiguous_.count(to_string(child.where));
  }
  is_possible_ &= is_there_once;
}

const Node* PatchedScene::node_at(const Location& where) const {
  const auto found = nodes_.find(to_string(where));
  return found == nodes_.end() ? nullptr : found->second;
}

const PatchedScene::File& PatchedScene::file(const std::string& name) {
  const auto known = files_.find(name);
  if (known != files_.end()) return known->second;
  const std::string& text = expansion_.texts.at(name);
  return files_.emplace(name, File{text, scan_source(text, name)}).first->second;
}

std::optional<std::string> PatchedScene::text() {
  if (!is_possible_) return std::nullopt;
  const File& root = file(name_);
  Patches inside;
  patch(root, root.root, nullptr, inside);
  // Defaults for -D must precede the scene's own: of several defaults with one name, the first is
  // used.
  std::vector<std::string> first;
  for (const auto& [name, value] : defines_) {
    const Location where{name_, 0, 0};
    first.push_back("<default name=\"" + attribute_text(name, where) + "\" value=\"" +
                    attribute_text(value, where) + "\"/>");
  }
  first.insert(first.end(), kept_.begin(), kept_.end());
  Patches patches;
  insert(root, root.root, first, patches);
  patches.insert(patches.end(), inside.begin(), inside.end());
  if (!is_possible_) return std::nullopt;
  return patched(root.text, 0, root.text.size(), std::move(patches));
}

/// Adds patches for an element. `owner` is the object that contains or includes it, or nullptr.
void PatchedScene::patch(const File& file, const SourceElement& element, Owner* owner,
                         Patches& patches) {
  const Node* const node = node_at(element.where);
  if (element.tag == "default") return;
  if (element.tag == "include") return patch_include(file, element, owner, patches);
  if (element.tag == "path") {
    const SourceElement::Attribute* const value = element.find("value");
    const auto found =
        value ? expansion_.found.find(to_string(value->where)) : expansion_.found.end();
    if (found == expansion_.found.end()) return;
    const std::string name = file.text.substr(value->value_begin, value->length());
    const std::string now = saved_.relocated(name, found->second);
    if (now != name) patches.push_back(replacement(*value, now));
    return;
  }
  if (!node) return patch_children(file, element, owner, patches);  // the root of an include
  if (owner && patch_value(file, element, *node, *owner, patches)) return;
  if (node->tag == "scene" || (is_object(*node) && node->tag != "ref")) {
    patch_object(file, element, *node, patches);
  }
}

void PatchedScene::patch_object(const File& file, const SourceElement& element, const Node& node,
                                Patches& patches) {
  const SavedScene::Changes* const changes = saved_.find(node);
  Owner own{&node};
  // Insertions must precede the children's patches, even if the first child begins at the same
  // offset.
  Patches of_children;
  patch_children(file, element, &own, of_children);
  if (wrappers_.count(&node)) patch_wrapper(file, element, node, patches);
  if (changes) patch_values(file, element, node, own, *changes, patches);
  patches.insert(patches.end(), of_children.begin(), of_children.end());
}

/// Patches the type of an object's element, and inserts the values that none of its children has.
void PatchedScene::patch_values(const File& file, const SourceElement& element, const Node& node,
                                const Owner& own, const SavedScene::Changes& changes,
                                Patches& patches) {
  const SourceElement::Attribute* const type = element.find("type");
  // If the node has another type than the text, the loader has replaced an unsupported plugin. Such
  // a scene can't be patched.
  const std::string written = type ? file.text.substr(type->value_begin, type->length()) : "";
  is_possible_ &= written == node.value("type") || written.find('$') != std::string::npos;
  if (type && changes.type != node.value("type")) {
    patches.push_back({type->value_begin, type->value_end, changes.type});
  }
  std::vector<std::string> missing;
  for (const auto& [name, text] : saved_.elements(node)) {
    if (!own.written.count(name)) missing.push_back(text);
  }
  insert(file, element, missing, patches);
}

/// Writes the BSDFs that a program has wrapped around the BSDF `node`. The id and name of `node`
/// move to the outermost wrapper.
void PatchedScene::patch_wrapper(const File& file, const SourceElement& element, const Node& node,
                                 Patches& patches) const {
  std::string moved;
  for (const char* const name : {"id", "name"}) {
    const SourceElement::Attribute* const attribute = element.find(name);
    if (!attribute) continue;
    // The removed text includes the blank before the attribute, and its closing quote.
    const size_t begin = attribute->begin - 1, end = attribute->value_end + 1;
    moved += ' ';
    moved.append(file.text, attribute->begin, end - attribute->begin);
    patches.push_back({begin, end, ""});
  }
  const bool has_line = begins_line(file.text, element.begin);
  const std::string line =
      has_line ? fmt::format("\n{}", indentation_at(file.text, element.begin)) : "";
  std::string before, after;
  for (auto at = wrappers_.find(&node); at != wrappers_.end(); at = wrappers_.find(at->second)) {
    const Node& outer = *at->second;
    const std::string own = wrappers_.count(&outer) ? "" : moved;
    before = fmt::format("<{} type=\"{}\"{}>{}{}{}", outer.tag,
                         attribute_text(outer.value("type"), outer.where), own,
                         saved_.contents(outer), line, before);
    after += fmt::format("</{}>", outer.tag);
  }
  patches.push_back({element.begin, element.begin, before});
  patches.push_back({element.end, element.end, after});
}

void PatchedScene::patch_children(const File& file, const SourceElement& element, Owner* owner,
                                  Patches& patches) {
  for (const SourceElement& child : element.children) patch(file, child, owner, patches);
}

/// Patches an element that is a value of `owner`. Returns false if it is a nested object that
/// remains a value of `owner`; its contents may still need patches.
bool PatchedScene::patch_value(const File& file, const SourceElement& element, const Node& node,
                               Owner& owner, Patches& patches) {
  const std::string name = node.value("name");
  const SavedScene::Changes* const changes = saved_.find(*owner.node);
  if (changes && !name.empty() && changes->overridden.count(name)) {
    if (is_object(node)) keep_elsewhere(file, element, node);
    for (const auto& [changed_name, text] : saved_.elements(*owner.node)) {
      if (changed_name != name) continue;
      owner.written.insert(name);
      patches.push_back({element.begin, element.end, text});
      return true;
    }
    patches.push_back(removal(file.text, element.begin, element.end));
    return true;
  }
  if (is_object(node)) return false;
  // A relative file name changes if the scene is saved to another folder.
  const bool is_spectrum = node.tag == "spectrum";
  const char* const attribute = is_spectrum ? "filename" : "value";
  const SourceElement::Attribute* const value = element.find(attribute);
  if (!value || (!is_spectrum && node.tag != "string")) return true;
  const std::string named = node.value(attribute);
  const std::string now = is_spectrum ? saved_.relocated_file(node, named)
                                      : saved_.relocated_value(*owner.node, name, named);
  if (now != named) patches.push_back(replacement(*value, now));
  return true;
}

/// Keeps an element that is no longer a value of its object but contains an object that others
/// refer to.
void PatchedScene::keep_elsewhere(const File& file, const SourceElement& element,
                                  const Node& node) {
  if (!holds_one_of(node, referenced_ids_)) return;
  Patches patches;
  patch_object(file, element, node, patches);
  if (const SourceElement::Attribute* const name = element.find("name")) {
    patches.push_back({name->begin - 1, name->value_end + 1, ""});  // with the blank before it
  }
  expand_names(file, element, patches);
  kept_.push_back(patched(file.text, element.begin, element.end, std::move(patches)));
}

/// Replaces $names by their values, because the element moves before the defaults that define them.
void PatchedScene::expand_names(const File& file, const SourceElement& element, Patches& patches) {
  const Node* const node = node_at(element.where);
  if (!node) {
    is_possible_ = false;  // later elements may depend on an include or a default that would move
    return;
  }
  for (const SourceElement::Attribute& attribute : element.attributes) {
    const std::string written = file.text.substr(attribute.value_begin, attribute.length());
    if (written.find('$') == std::string::npos || is_within(attribute, patches)) continue;
    patches.push_back(replacement(attribute, node->value(attribute.name)));
  }
  for (const SourceElement& child : element.children) expand_names(file, child, patches);
}

/// Patches an include. If edits change the included text, the changed text goes to a new file, and
/// the include refers to that file. Otherwise only a relative file name may change.
void PatchedScene::patch_include(const File& file, const SourceElement& element, Owner* owner,
                                 Patches& patches) {
  const SourceElement::Attribute* const filename = element.find("filename");
  const auto found =
      filename ? expansion_.found.find(to_string(filename->where)) : expansion_.found.end();
  if (found == expansion_.found.end()) return;
  const std::string& path = found->second;
  const std::string folder = saved_.folder();
  const auto kept = kept_;
  const auto includes = includes_;
  const auto names = saved_.names();
  Owner unused{owner ? owner->node : nullptr};
  // Patches the included text once as a trial, as if saved in its own folder, to see if it changes.
  // The state is restored afterwards.
  saved_.set_folder(folder_of(path));
  const bool stays = included_text(path, owner ? &unused : nullptr) == expansion_.texts.at(path);
  saved_.set_folder(folder);
  kept_ = kept;
  includes_ = includes;
  saved_.set_names(names);
  std::string now = file.text.substr(filename->value_begin, filename->length());
  if (stays) {
    const std::string moved = saved_.relocated(now, path);
    if (moved == now) return;
    now = moved;
  } else {
    now = saved_.new_name(fs::path(path).stem().string(), ".xml", path);
    includes_[(fs::path(folder) / now).string()] = included_text(path, owner);
  }
  patches.push_back(replacement(*filename, now));
}

std::string PatchedScene::included_text(const std::string& path, Owner* owner) {
  const File& included = file(path);
  Patches patches;
  if (included.root.tag == "scene") {
    patch_children(included, included.root, owner, patches);
  } else {
    patch(included, included.root, owner, patches);
  }
  return patched(included.text, 0, included.text.size(), std::move(patches));
}

/// Inserts elements before the children of an element.
void PatchedScene::insert(const File& file, const SourceElement& element,
                          const std::vector<std::string>& elements, Patches& patches) const {
  if (elements.empty()) return;
  const auto& children = element.children;
  const bool has_lines =
      begins_line(file.text, children.empty() ? element.begin : children.front().begin);
  const std::string outer = indentation_at(file.text, element.begin);
  const std::string inner =
      children.empty() ? outer + "  " : indentation_at(file.text, children.front().begin);
  std::string text;
  for (const std::string& one : elements) {
    if (has_lines) text += "\n" + inner;
    text += one;
  }
  if (element.is_one_tag) {
    const size_t slash = file.text.rfind('/', element.end - 1);
    const std::string last = (has_lines ? "\n" + outer : "") + "</" + element.tag + ">";
    patches.push_back({slash, element.end, ">" + text + last});
    return;
  }
  const size_t line = file.text.find('\n', element.content_begin);
  if (has_lines && line >= element.content_end) text += "\n" + outer;
  patches.push_back({element.content_begin, element.content_begin, text});
}

}  // namespace kinome::loader
