// An edited scene's text, from that of the files that it was read from.

#include "loader/patched_scene.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "loader/written_values.h"

namespace kinome::loader {
namespace {

namespace fs = std::filesystem;

std::string folder_of_file(const std::string& file) {
  const fs::path folder = fs::path(file).parent_path();
  return (folder.empty() ? fs::path(".") : folder).string();
}

void collect_references(const Node& node, std::set<std::string>& ids,
                        const std::map<std::string, std::string>& aliases) {
  if (node.tag == "ref") {
    std::string id = node.value("id");
    for (auto alias = aliases.find(id); alias != aliases.end(); alias = aliases.find(id)) {
      id = alias->second;
    }
    ids.insert(id);
  }
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

/// With the blanks before it, and the line if it has that for itself.
TextPatch removal(const std::string& text, size_t begin, size_t end) {
  if (!begins_line(text, begin)) return {begin, end, ""};
  const size_t before = begin == 0 ? std::string::npos : text.find_last_not_of(" \t", begin - 1);
  return {before == std::string::npos ? 0 : before, end, ""};
}

TextPatch replacement(const SourceElement::Attribute& attribute, const std::string& value) {
  return {attribute.value_begin, attribute.value_end, said_text(value, attribute.where)};
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
  note_places(expansion.root);
  collect_references(expansion.root, referred_, expansion.aliases);
  for (const auto& [node, said] : saved.all()) check(*node);
}

void PatchedScene::note_places(const Node& node) {
  const std::string place = to_string(node.where);
  if (!node.is_put && !nodes_.emplace(place, &node).second) twice_.insert(place);
  if (node.inner) around_[node.inner.get()] = &node;
  for_each_part(node, [this](const Node& child) { note_places(child); });
}

/// Of an object that says other than its text.
void PatchedScene::check(const Node& node) {
  if (node.is_put) return;
  bool is_there_once = !twice_.count(to_string(node.where));
  for (const Node& child : node.children) {
    is_there_once &= !twice_.count(to_string(child.where));
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
  // What is to be said before all else: of several defaults of a name the first counts.
  std::vector<std::string> first;
  for (const auto& [name, value] : defines_) {
    const Location where{name_, 0, 0};
    first.push_back("<default name=\"" + said_text(name, where) + "\" value=\"" +
                    said_text(value, where) + "\"/>");
  }
  first.insert(first.end(), kept_.begin(), kept_.end());
  Patches patches;
  insert(root, root.root, first, patches);
  patches.insert(patches.end(), inside.begin(), inside.end());
  if (!is_possible_) return std::nullopt;
  return patched(root.text, 0, root.text.size(), std::move(patches));
}

/// `owner`: the object that it stands in, or that it is included into; nullptr: none.
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
  const SavedScene::Said* const said = saved_.find(node);
  Owner own{&node};
  // What is inserted comes before them, also if the first child begins at the same place.
  Patches of_children;
  patch_children(file, element, &own, of_children);
  if (around_.count(&node)) patch_around(file, element, node, patches);
  if (said) patch_values(file, element, node, own, *said, patches);
  patches.insert(patches.end(), of_children.begin(), of_children.end());
}

/// Patches the type of an object's element, and inserts the values that none of its children states.
void PatchedScene::patch_values(const File& file, const SourceElement& element, const Node& node,
                                const Owner& own, const SavedScene::Said& said, Patches& patches) {
  const SourceElement::Attribute* const type = element.find("type");
  // Something else may stand in for what its text says.
  const std::string written = type ? file.text.substr(type->value_begin, type->length()) : "";
  is_possible_ &= written == node.value("type") || written.find('$') != std::string::npos;
  if (type && said.type != node.value("type")) {
    patches.push_back({type->value_begin, type->value_end, said.type});
  }
  std::vector<std::string> missing;
  for (const auto& [name, text] : saved_.elements(node)) {
    if (!own.said.count(name)) missing.push_back(text);
  }
  insert(file, element, missing, patches);
}

/// What a program has put around a BSDF has its id and its name.
void PatchedScene::patch_around(const File& file, const SourceElement& element, const Node& node,
                                Patches& patches) const {
  std::string moved;
  for (const char* const name : {"id", "name"}) {
    const SourceElement::Attribute* const attribute = element.find(name);
    if (!attribute) continue;
    // With its quotes, and with the blank before it.
    const size_t begin = attribute->begin - 1, end = attribute->value_end + 1;
    moved += ' ';
    moved.append(file.text, attribute->begin, end - attribute->begin);
    patches.push_back({begin, end, ""});
  }
  const bool has_line = begins_line(file.text, element.begin);
  const std::string line =
      has_line ? fmt::format("\n{}", indentation_at(file.text, element.begin)) : "";
  std::string before, after;
  for (auto at = around_.find(&node); at != around_.end(); at = around_.find(at->second)) {
    const Node& outer = *at->second;
    // The outermost one has them.
    const std::string own = around_.count(&outer) ? "" : moved;
    before = fmt::format("<{} type=\"{}\"{}>{}{}{}", outer.tag,
                         said_text(outer.value("type"), outer.where), own, saved_.contents(outer),
                         line, before);
    after += fmt::format("</{}>", outer.tag);
  }
  patches.push_back({element.begin, element.begin, before});
  patches.push_back({element.end, element.end, after});
}

void PatchedScene::patch_children(const File& file, const SourceElement& element, Owner* owner,
                                  Patches& patches) {
  for (const SourceElement& child : element.children) patch(file, child, owner, patches);
}

/// Whether the element is a value of its object, or stands for one that is not what it was.
bool PatchedScene::patch_value(const File& file, const SourceElement& element, const Node& node,
                               Owner& owner, Patches& patches) {
  const std::string name = node.value("name");
  const SavedScene::Said* const said = saved_.find(*owner.node);
  if (said && !name.empty() && said->unsaid.count(name)) {
    if (is_object(node)) keep_elsewhere(file, element, node);
    for (const auto& [said_name, text] : saved_.elements(*owner.node)) {
      if (said_name != name) continue;
      owner.said.insert(name);
      patches.push_back({element.begin, element.end, text});
      return true;
    }
    patches.push_back(removal(file.text, element.begin, element.end));
    return true;
  }
  if (is_object(node)) return false;
  // Files are where they were, though the scene may be somewhere else.
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

/// What something refers to, though it is no value of its object any more.
void PatchedScene::keep_elsewhere(const File& file, const SourceElement& element,
                                  const Node& node) {
  if (!holds_one_of(node, referred_)) return;
  Patches patches;
  patch_object(file, element, node, patches);
  if (const SourceElement::Attribute* const name = element.find("name")) {
    patches.push_back({name->begin - 1, name->value_end + 1, ""});  // with the blank before it
  }
  say_expanded(file, element, patches);
  kept_.push_back(patched(file.text, element.begin, element.end, std::move(patches)));
}

/// What $ stands for, as the element is to stand before the defaults that say so.
void PatchedScene::say_expanded(const File& file, const SourceElement& element, Patches& patches) {
  const Node* const node = node_at(element.where);
  if (!node) {
    is_possible_ = false;  // an include or a default, which others after it may need where it is
    return;
  }
  for (const SourceElement::Attribute& attribute : element.attributes) {
    const std::string written = file.text.substr(attribute.value_begin, attribute.length());
    if (written.find('$') == std::string::npos || is_within(attribute, patches)) continue;
    patches.push_back(replacement(attribute, node->value(attribute.name)));
  }
  for (const SourceElement& child : element.children) say_expanded(file, child, patches);
}

/// An include that says what it did where it is stays there.
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
  saved_.set_folder(folder_of_file(path));
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

/// Elements, before the others that stand in an element.
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
