#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include <fmt/format.h>

#include "file_search.h"
#include "fnv1a.h"
#include "scene_loader_node.h"

namespace kinome::loader {
namespace {

namespace fs = std::filesystem;

constexpr size_t kDeepestInclude = 15;
/// Files that include others twice, which include others twice, …: an end to that.
constexpr int kMostIncludes = 2000;
/// And to large files that are included many times: bytes of all includes but the first of each.
constexpr size_t kMostRepeated = 4 << 20;
/// And to defaults that double one another: bytes of one attribute, and of all that are
/// substituted.
constexpr size_t kLongestAttribute = 1 << 20;
constexpr size_t kMostSubstituted = 64 << 20;

/// What $x stands for: -D and <default>.
class Substitution {
 public:
  explicit Substitution(const std::map<std::string, std::string>& defines) : values_(defines) {
    for (const auto& [name, value] : defines) unused_.insert(name);
  }

  /// The first value of a name stays: -D beats every default.
  void add_default(const std::string& name, const std::string& value) {
    values_.emplace(name, value);
  }

  std::string apply(const Attribute& attribute) {
    std::string result;
    std::string_view rest = attribute.value;
    for (size_t dollar; (dollar = rest.find('$')) != std::string_view::npos;) {
      result += rest.substr(0, dollar);
      rest.remove_prefix(dollar + 1);
      const auto& [name, value] = longest_match(rest, attribute.where);
      result += value;
      rest.remove_prefix(name.size());
      unused_.erase(name);
      if (result.size() > kLongestAttribute) {
        throw Error(attribute.where, "the value grows too long by substitution");
      }
      total_ += value.size();
      if (total_ > kMostSubstituted) {
        throw Error(attribute.where, "the scene grows too large by substitution");
      }
    }
    return result += rest;
  }

  void check_all_used(const std::string& file) const {
    if (unused_.empty()) return;
    std::vector<std::string> others;
    for (const auto& [name, value] : values_) {
      if (!unused_.count(name)) others.push_back(name);
    }
    const std::string& name = *unused_.begin();
    throw Error(Location{file, 0, 0},
                "nothing in the scene uses -D " + name + did_you_mean(nearest_name(name, others)));
  }

 private:
  const std::pair<const std::string, std::string>& longest_match(std::string_view text,
                                                                 const Location& where) const {
    const std::pair<const std::string, std::string>* best = nullptr;
    for (const auto& entry : values_) {
      if (text.starts_with(entry.first) && (!best || entry.first.size() > best->first.size())) {
        best = &entry;
      }
    }
    if (best) return *best;
    const auto is_name = [](char c) {
      return c == '_' || std::isalnum(static_cast<unsigned char>(c));
    };
    const std::string name(text.begin(), std::find_if_not(text.begin(), text.end(), is_name));
    std::vector<std::string> known;
    for (const auto& entry : values_) known.push_back(entry.first);
    throw Error(where, "undefined parameter '$" + name + "'" +
                           did_you_mean(nearest_name(name, known), "$"));
  }

  std::map<std::string, std::string> values_;
  std::set<std::string> unused_;
  size_t total_ = 0;
};

class Expander {
 public:
  Expander(const std::string& name, const LoadOptions& options)
      : name_(name), options_(options), substitution_(options.defines) {}

  Expansion run(const std::string& text, bool whole_scene) {
    add_to_hash(text);
    Node root = parse(text, name_);
    if (whole_scene && root.tag != "scene") {
      throw Error(root.where, "the root must be <scene>, not " + quoted_tag(root));
    }
    upgrade(root, whole_scene);
    files_.push_back(name_);
    check_node(root, nullptr);
    result_.root = expand_node(root, true);
    substitution_.check_all_used(name_);
    for (const auto& [key, value] : options_.defines) add_to_hash(key + "=" + value);
    result_.hash = fmt::format("{:016x}", hash_.value());
    return std::move(result_);
  }

 private:
  /// The node with its substituted attributes and its expanded children.
  Node expand_node(const Node& node, bool is_file_root) {
    Node copy{node.tag, substituted(node), {}, node.where, folders_};
    note_id(copy);
    expand_children(node, is_file_root, copy.children);
    return copy;
  }

  std::vector<Attribute> substituted(const Node& node) {
    std::vector<Attribute> attributes = node.attributes;
    for (Attribute& attribute : attributes) attribute.value = substitution_.apply(attribute);
    return attributes;
  }

  void expand_children(const Node& node, bool is_file_root, std::vector<Node>& out) {
    for (const Node& child : node.children) {
      const TagKind kind = check_node(child, &node);
      if (kind != TagKind::kDefault && kind != TagKind::kInclude && kind != TagKind::kPath &&
          kind != TagKind::kAlias) {
        out.push_back(expand_node(child, false));
        continue;
      }
      if (!child.children.empty()) check_node(child.children.front(), &child);
      const Node directive{child.tag, substituted(child), {}, child.where, nullptr};
      if (kind == TagKind::kDefault) {
        substitution_.add_default(directive.value("name"), directive.value("value"));
      } else if (kind == TagKind::kInclude) {
        include(directive, node, out);
      } else if (kind == TagKind::kPath) {
        if (!is_file_root) throw Error(child.where, "<path> must be a child of the root");
        add_path(directive);
      } else {
        add_alias(directive);
      }
    }
  }

  void include(const Node& node, const Node& parent, std::vector<Node>& out) {
    const Attribute& attribute = *node.find("filename");
    const std::string path = find(attribute);
    if (files_.size() > kDeepestInclude) {
      throw Error(attribute.where,
                  fmt::format("includes are nested more than {} deep", kDeepestInclude));
    }
    for (const std::string& file : files_) {
      std::error_code failed;
      if (fs::equivalent(file, path, failed)) {
        throw Error(attribute.where, "'" + path + "' includes itself");
      }
    }
    if (++includes_ > kMostIncludes) throw Error(attribute.where, "too many includes");
    const std::string text = read_text(path, attribute.where);
    if (!included_.insert(path).second && (repeated_ += text.size()) > kMostRepeated) {
      throw Error(attribute.where, "'" + path + "' and others are included too many times");
    }
    add_to_hash(text);
    Node root = parse(text, path);
    upgrade(root, true);
    check_node(root, nullptr);

    const auto outer_folders = folders_;
    auto folders = outer_folders ? *outer_folders : std::vector<std::string>();
    folders.insert(folders.begin(), folder_of(path));
    folders_ = std::make_shared<const std::vector<std::string>>(std::move(folders));
    files_.push_back(path);
    if (root.tag == "scene") {
      root.tag = parent.tag;  // dissolved: its children stand inside of the parent
      expand_children(root, true, out);
    } else {
      check_node(root, &parent);
      out.push_back(expand_node(root, true));
    }
    files_.pop_back();
    folders_ = outer_folders;
  }

  /// Relative to the file's own folder, or else to the search path.
  void add_path(const Node& node) {
    const Attribute& attribute = *node.find("value");
    std::error_code failed;
    std::vector<std::string> folders = search_folders();
    folders.insert(folders.begin(), folder_of(files_.back()));
    for (const std::string& folder : folders) {
      const fs::path path = fs::path(folder) / attribute.value;
      if (!fs::is_directory(path, failed)) continue;
      result_.paths.insert(result_.paths.begin(), path.string());
      return;
    }
    throw Error(attribute.where, "there is no folder '" + attribute.value + "'");
  }

  void add_alias(const Node& node) {
    const Attribute& id = *node.find("id");
    const Attribute& as = *node.find("as");
    if (!ids_.count(id.value)) {
      std::vector<std::string> known;
      for (const auto& entry : ids_) known.push_back(entry.first);
      throw Error(id.where, "nothing above has the id '" + id.value + "'" +
                                did_you_mean(nearest_name(id.value, known)));
    }
    add_id(as);
    result_.aliases[as.value] = id.value;
  }

  void note_id(const Node& node) {
    const Attribute* id = node.find("id");
    if (id && node.tag != "ref") add_id(*id);
  }

  void add_id(const Attribute& id) {
    const auto [other, is_new] = ids_.emplace(id.value, id.where);
    if (is_new) return;
    throw Error(id.where, "the id '" + id.value + "' is given twice (first at " +
                              to_string(other->second) + ")");
  }

  std::vector<std::string> search_folders() const {
    std::vector<std::string> all = folders_ ? *folders_ : std::vector<std::string>();
    all.insert(all.end(), result_.paths.begin(), result_.paths.end());
    for (std::string& folder : base_folders(name_, options_)) all.push_back(std::move(folder));
    return all;
  }

  std::string find(const Attribute& attribute) const {
    try {
      return find_file(attribute.value, search_folders());
    } catch (const Error& error) {
      throw Error(attribute.where, error.message());
    }
  }

  /// With the zero at its end: texts must not run into one another.
  void add_to_hash(const std::string& text) { hash_.add(text.c_str(), text.size() + 1); }

  static std::string folder_of(const std::string& file) {
    const std::string folder = fs::path(file).parent_path().string();
    return folder.empty() ? "." : folder;
  }

  const std::string& name_;
  const LoadOptions& options_;
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
  std::vector<std::string> folders{"."};
  folders.insert(folders.end(), options.search_paths.begin(), options.search_paths.end());
  const std::string own = fs::path(scene_file).parent_path().string();
  if (!own.empty()) folders.push_back(own);
  return folders;
}

std::string read_text(const std::string& path, const Location& where) {
  std::error_code failed;
  const Location place = where.file.empty() ? Location{path, 0, 0} : where;
  const std::string title = where.file.empty() ? "it" : "'" + path + "'";
  if (!fs::exists(path, failed)) throw Error(place, "there is no such file");
  if (const std::string why = unreadable(path); !why.empty()) {
    throw Error(place, title + " " + why);
  }
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(place, title + " can't be read");
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw Error(place, title + " can't be read");
  return text;
}

Expansion expand(const std::string& text, const std::string& name, const LoadOptions& options,
                 bool whole_scene) {
  return Expander(name, options).run(text, whole_scene);
}

}  // namespace kinome::loader
