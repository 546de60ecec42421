#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "kinome/color.h"
#include "kinome/error.h"
#include "kinome/object.h"
#include "kinome/parameter.h"

namespace kinome {

struct Image;
class Texture;

/// A uniform colour or grey as the scene wrote it. `spectral` holds for <spectrum>, whose uniform
/// value is white for a reflectance and the equal-energy white for a light.
struct UniformColor {
  Rgb value{0.f};
  bool spectral = false;
  bool is_float = false;  ///< written as <float> or <integer>
};

/// A number that a scene can call by name.
struct NamedNumber {
  const char* name;
  float value;
};

/// The typed parameters of one plugin object, each with its place in the scene file. The loader
/// checks them against the plugin's table before the plugin sees them, so that getters only fail
/// for values that the plugin's own code rejects. Getters fall back on the table's default.
/// Not thread-safe; used only while a scene loads.
class KINOME_EXPORT Properties {
 public:
  using Value = std::variant<bool, int64_t, double, std::string, Vec3, UniformColor, Transform,
                             std::shared_ptr<const Image>, std::shared_ptr<Object>>;
  struct Entry {
    Value value;
    Location where;
    mutable bool read = false;
  };

  Properties(Category category, std::string plugin_name, Location where);

  /// Set by the registry before the plugin's constructor runs.
  void set_table(std::span<const Parameter> table) { table_ = table; }
  /// Throws Error where `name` is there already.
  void set(const std::string& name, Value value, const Location& where);

  Category category() const { return category_; }
  const std::string& plugin_name() const { return plugin_name_; }
  const std::string& id() const { return id_; }
  void set_id(std::string id) { id_ = std::move(id); }
  const Location& where() const { return where_; }
  /// In the order of the file.
  const std::vector<std::pair<std::string, Entry>>& entries() const { return entries_; }

  bool has(const std::string& name) const;
  bool boolean(const std::string& name) const;
  int64_t integer(const std::string& name) const;
  /// An Error where it lies outside [low, high].
  uint32_t integer(const std::string& name, uint32_t low, uint32_t high) const;
  float real(const std::string& name) const;
  /// Of a kFloatOrName parameter: the number, or the one that the string stands for in `names`; an
  /// Error with the nearest name otherwise.
  float number_or_name(const std::string& name, std::span<const NamedNumber> names) const;
  std::string string(const std::string& name) const;
  /// The file that a kFile parameter names: found in the search paths, or an Error that says where
  /// it was looked for.
  std::string file(const std::string& name) const;
  Vec3 vector(const std::string& name) const;
  /// For light: <float> is grey, <rgb> itself, a uniform <spectrum> equal-energy white in Rec.709.
  Rgb color(const std::string& name) const;
  /// The identity where neither the scene nor the table says anything.
  Transform transform(const std::string& name) const;
  /// A <texture>, or a uniform value wrapped as one: where the parameter is an emission, as color()
  /// gives it. nullptr only where there is no default.
  std::shared_ptr<Texture> texture(const std::string& name) const;
  /// Pixels that a program gives in place of a file, linear, of one or of three channels or more;
  /// nullptr: it gives none.
  std::shared_ptr<const Image> image(const std::string& name) const;
  /// The string as an index into its row's choices; an Error with a suggestion otherwise.
  int choice(const std::string& name) const;

  /// All nested objects of class T (Bsdf, Film, …), in the order of the file.
  template <class T>
  std::vector<std::shared_ptr<T>> objects() const {
    std::vector<std::shared_ptr<T>> found;
    for (const auto& [name, entry] : entries_) {
      if (const auto* object = std::get_if<std::shared_ptr<Object>>(&entry.value)) {
        if (auto t = std::dynamic_pointer_cast<T>(*object)) {
          entry.read = true;
          found.push_back(std::move(t));
        }
      }
    }
    return found;
  }
  /// The first of them, or nullptr.
  template <class T>
  std::shared_ptr<T> object() const {
    auto all = objects<T>();
    return all.empty() ? nullptr : all.front();
  }

  /// An Error at parameter `name` (or at the object, where the scene doesn't set it):
  /// `throw props.error("alpha", "must be positive, got -1")`.
  Error error(const std::string& name, const std::string& message) const;
  /// A warning with the same prefix, through the log.
  void warn(const std::string& name, const std::string& message) const;

  /// Folders in which file() looks, in order; shared by all properties of a scene.
  void set_search_paths(std::shared_ptr<const std::vector<std::string>> paths) {
    search_paths_ = std::move(paths);
  }

 private:
  const Entry* find(const std::string& name) const;
  const Parameter& parameter(const std::string& name) const;
  /// What the scene says, or the table's default.
  Value value(const std::string& name) const;

  Category category_;
  std::string plugin_name_;
  std::string id_;
  Location where_;
  std::span<const Parameter> table_;
  std::vector<std::pair<std::string, Entry>> entries_;
  std::shared_ptr<const std::vector<std::string>> search_paths_;
};

}  // namespace kinome
