// Directives of a scene file: includes, paths, defaults, aliases, and $names in attributes.

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "base/file_search.h"
#include "base/fnv1a.h"
#include "kinome/log.h"
#include "kinome/read_files.h"
#include "scene_xml/nodes/node.h"
#include "scene_xml/nodes/substitute.h"
#include "scene_xml/nodes/text_encoding.h"

namespace kinome::loader {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxIncludeDepth = 15;
/// Limits the exponential growth of files that include others twice, which do the same.
constexpr int kMaxIncludes = 2000;
/// Maximum bytes of repeated includes, without the first include of each file.
constexpr size_t kMaxRepeatedBytes = 4 << 20;

bool is_directive(TagKind kind) {
  return kind == TagKind::kDefault || kind == TagKind::kInclude || kind == TagKind::kPath ||
         kind == TagKind::kAlias;
}

class Expander {
 public:
  Expander(const std::string& name, const LoadOptions& options, Faults& faults)
      : name_(name), options_(options), faults_(faults), substitution_(options.defines, faults) {}

  Expansion run(const std::string& bytes, bool whole_scene) {
    add_to_hash(bytes);
    const std::string text = as_utf8(bytes);
    Node root = parse(text, name_, faults_);
    if (whole_scene && root.tag != "scene") {
      throw Error(root.where, "the root must be <scene>, not " + quoted_tag(root));
    }
    result_.is_of_old_version |= upgrade(root, whole_scene, faults_);
    result_.texts[name_] = text;
    files_.push_back(name_);
    const bool is_fine = check_node(root, nullptr, faults_);
    result_.root = expand_node(root, true, is_fine);
    substitution_.check_all_used(name_);
    for (const auto& [key, value] : options_.defines) add_to_hash(key + "=" + value);
    result_.hash = fmt::format("{:016x}", hash_.value());
    return std::move(result_);
  }

 private:
  /// Returns the node with substituted attributes and expanded children.
  Node expand_node(const Node& node, bool is_file_root, bool is_fine) {
    Node copy{node.tag, node.attributes, {}, node.where, folders_, !is_fine};
    copy.is_old = node.is_old;
    substitute(copy);
    drop_empty_names(copy);
    note_id(copy);
    // Children of an invalid value are ignored.
    if (is_fine || kind_of(node) == TagKind::kObject) {
      expand_children(node, is_file_root, copy.children);
    }
    return copy;
  }

  /// Removes empty ids and names, which Mitsuba ignores.
  static void drop_empty_names(Node& node) {
    const TagKind kind = kind_of(node);
    if (kind != TagKind::kObject && kind != TagKind::kRef) return;
    std::erase_if(node.attributes, [](const Attribute& attribute) {
      return (attribute.name == "id" || attribute.name == "name") && attribute.value.empty();
    });
  }

  void substitute(Node& node) {
    for (Attribute& attribute : node.attributes) {
      if (auto value = substitution_.apply(attribute)) {
        attribute.value = std::move(*value);
        continue;
      }
      node.is_broken = true;
      if (attribute.name == "id" && node.tag != "ref") result_.has_unknown_ids = true;
    }
  }

  void expand_children(const Node& node, bool is_file_root, std::vector<Node>& out) {
    for (const Node& child : node.children) {
      const bool is_fine = check_node(child, &node, faults_);
      const TagKind kind = kind_of(child);
      if (!is_fine) lose_names(child);
      if (!is_directive(kind)) {
        out.push_back(expand_node(child, false, is_fine));
        continue;
      }
      for (const Node& inner : child.children) check_node(inner, &child, faults_);
      Node directive{child.tag, child.attributes, {}, child.where, nullptr, !is_fine};
      substitute(directive);
      const auto follow = [&] {
        if (kind == TagKind::kDefault) {
          substitution_.add_default(directive.value("name"), directive.value("value"));
        } else if (kind == TagKind::kInclude) {
          include(directive, node, out);
        } else if (kind == TagKind::kPath) {
          add_path(directive, is_file_root);
        } else {
          add_alias(directive);
        }
      };
      if (directive.is_broken || !faults_.attempt(follow)) lose(directive, out);
    }
  }

  /// Records names and ids that a wrong tag or attribute hides, so that references to them aren't
  /// errors.
  void lose_names(const Node& node) {
    for (const Attribute& attribute : node.attributes) {
      const bool is_id = !nearest_name(attribute.name, std::array{"id"}).empty();
      if (is_id && (attribute.name != "id" || attribute.value.empty())) {
        result_.has_unknown_ids = true;
      }
    }
    if (has_known_tag(node)) return;
    // It may have been meant as a <default>, an <alias> or an <include>.
    if (const Attribute* name = node.find("name")) substitution_.lose(name->value);
    if (const Attribute* as = node.find("as")) result_.lost_ids.insert(as->value);
    if (node.find("filename")) lose_all_names();
  }

  void lose_all_names() {
    substitution_.lose("");
    result_.has_unknown_ids = true;
  }

  /// Records the names that are undefined because a directive failed with a reported error.
  void lose(const Node& directive, std::vector<Node>& out) {
    switch (kind_of(directive)) {
      case TagKind::kDefault:
        substitution_.lose(directive.value("name"));
        break;
      case TagKind::kInclude:
        lose_all_names();
        out.push_back({directive.tag, {}, {}, directive.where, nullptr, true});
        break;
      case TagKind::kPath:
        faults_.expect_missing_files();
        break;
      default:
        if (has_certain(directive, "as")) {
          result_.lost_ids.insert(directive.value("as"));
        } else {
          result_.has_unknown_ids = true;
        }
    }
  }

  void include(const Node& node, const Node& parent, std::vector<Node>& out) {
    const Attribute& attribute = *node.find("filename");
    const std::string path = find_file(attribute.value, search_folders(), attribute.where);
    if (files_.size() > kMaxIncludeDepth) {
      throw Error(attribute.where,
                  fmt::format("includes are nested more than {} deep", kMaxIncludeDepth));
    }
    for (const std::string& file : files_) {
      std::error_code failed;
      if (fs::equivalent(file, path, failed)) {
        throw Error(attribute.where, "'" + path + "' includes itself");
      }
    }
    if (++includes_ > kMaxIncludes) faults_.stop(Error(attribute.where, "too many includes"));
    const std::string text = as_utf8(read_text(path, attribute.where));
    if (!included_.insert(path).second && (repeated_ += text.size()) > kMaxRepeatedBytes) {
      faults_.stop(Error(attribute.where, "'" + path + "' and others are included too many times"));
    }
    faults_.note_include(path, attribute.where);
    add_to_hash(text);
    Node root = parse(text, path, faults_);
    result_.is_of_old_version |= upgrade(root, true, faults_);
    result_.texts[path] = text;
    result_.found[to_string(attribute.where)] = path;
    const bool is_fine = check_node(root, nullptr, faults_);

    const auto outer_folders = folders_;
    auto folders = outer_folders ? *outer_folders : std::vector<std::string>();
    folders.insert(folders.begin(), folder_of(path));
    folders_ = std::make_shared<const std::vector<std::string>>(std::move(folders));
    files_.push_back(path);
    if (root.tag == "scene") {
      root.tag = parent.tag;  // the children of an included <scene> belong to the parent
      expand_children(root, true, out);
    } else {
      out.push_back(expand_node(root, true, is_fine && check_node(root, &parent, faults_)));
    }
    files_.pop_back();
    folders_ = outer_folders;
  }

  /// Adds a folder, relative to the folder of the file or to another folder that is searched for
  /// files.
  void add_path(const Node& node, bool is_file_root) {
    if (!is_file_root) throw Error(node.where, "<path> must be a child of the root");
    const Attribute& attribute = *node.find("value");
    std::error_code failed;
    for (const std::string& folder : search_folders()) {
      const fs::path path = fs::path(folder) / attribute.value;
      if (!fs::is_directory(path, failed)) continue;
      if (folder == kWorkingDirectory && path.is_relative()) {
        log_warn(Error(attribute.where, "the folder '" + attribute.value +
                                            "' was found only in the working directory, so that "
                                            "the scene can't be rendered from another one")
                     .what());
      }
      result_.found[to_string(attribute.where)] = path.string();
      result_.paths.insert(result_.paths.begin(), path.string());
      return;
    }
    throw Error(attribute.where, "no such folder: '" + attribute.value + "'");
  }

  void add_alias(const Node& node) {
    const Attribute& id = *node.find("id");
    const Attribute& as = *node.find("as");
    if (!ids_.count(id.value)) {
      if (result_.has_unknown_ids || result_.lost_ids.count(id.value)) {
        result_.lost_ids.insert(as.value);
        return;
      }
      std::vector<std::string> known;
      for (const auto& entry : ids_) known.push_back(entry.first);
      throw Error(id.where, "no earlier object has the id '" + id.value + "'" +
                                did_you_mean(faults_.nearest(id.value, known)));
    }
    add_id(as);
    result_.aliases[as.value] = id.value;
  }

  void note_id(const Node& node) {
    const Attribute* id = node.find("id");
    if (!id || node.tag == "ref") return;
    if (has_known_tag(node)) {
      faults_.attempt([&] { add_id(*id); });
    } else {
      ids_.emplace(id->value,
                   id->where);  // may be a misspelt <alias>, whose id is that of another object
    }
  }

  void add_id(const Attribute& id) {
    const auto [other, is_new] = ids_.emplace(id.value, id.where);
    if (is_new) return;
    throw Error(id.where, "the id '" + id.value + "' is given twice (first at " +
                              to_string(other->second) + ")");
  }

  std::vector<std::string> search_folders() const {
    return kinome::loader::search_folders(folders_.get(), result_.paths,
                                          base_folders(name_, options_));
  }

  /// Hashes the terminating zero, too, which separates texts.
  void add_to_hash(const std::string& text) { hash_.add(text.c_str(), text.size() + 1); }

  const std::string& name_;
  const LoadOptions& options_;
  Faults& faults_;
  Substitution substitution_;
  Fnv1a hash_;
  Expansion result_;
  std::map<std::string, Location> ids_;
  std::vector<std::string> files_;  ///< the scene, then the includes that are being read
  std::shared_ptr<const std::vector<std::string>> folders_;
  int includes_ = 0;
  std::set<std::string> included_;
  size_t repeated_ = 0;
};

}  // namespace

std::vector<std::string> base_folders(const std::string& scene_file, const LoadOptions& options) {
  const std::string own = fs::path(scene_file).parent_path().string();
  std::vector<std::string> folders{own.empty() ? "." : own};
  folders.insert(folders.end(), options.search_paths.begin(), options.search_paths.end());
  std::error_code failed;
  if (!fs::equivalent(folders.front(), ".", failed)) folders.push_back(kWorkingDirectory);
  return folders;
}

std::vector<std::string> search_folders(const std::vector<std::string>* includes,
                                        const std::vector<std::string>& paths,
                                        const std::vector<std::string>& base) {
  std::vector<std::string> all = includes ? *includes : std::vector<std::string>();
  all.push_back(base.front());
  all.insert(all.end(), paths.begin(), paths.end());
  all.insert(all.end(), base.begin() + 1, base.end());
  return all;
}

std::string unaliased(const std::map<std::string, std::string>& aliases, std::string name) {
  // The limit ends cycles.
  for (size_t i = 0; i < aliases.size(); ++i) {
    const auto alias = aliases.find(name);
    if (alias == aliases.end()) break;
    name = alias->second;
  }
  return name;
}

std::string read_text(const std::string& path, const Location& where) {
  std::error_code failed;
  const Location location = where.file.empty() ? Location{path, 0, 0} : where;
  const std::string title = where.file.empty() ? "it" : "'" + path + "'";
  if (!fs::exists(path, failed)) throw Error(location, "no such file");
  if (const std::string why = unreadable(path); !why.empty()) {
    throw Error(location, title + " " + why);
  }
  try {
    return file_contents(path);
  } catch (const Error& error) {
    throw Error(location, title + " " + error.message());
  }
}

Expansion expand(const std::string& text, const std::string& name, const LoadOptions& options,
                 bool whole_scene, Faults& faults) {
  return Expander(name, options, faults).run(text, whole_scene);
}

}  // namespace kinome::loader
