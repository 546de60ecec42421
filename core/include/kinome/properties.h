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
class Volume;

/// Uniform colour or grey as written in the scene. `spectral` is true for <spectrum>: a uniform
/// spectrum is white as a reflectance, and equal-energy white as emission.
struct UniformColor {
  Rgb value{0.f};
  bool spectral = false;
  bool is_float = false;  ///< written as <float> or <integer>
};

/// Number that scenes can refer to by name, such as an index of refraction.
struct NamedNumber {
  const char* name;
  float value;
};

/// Typed parameters of one plugin object, each with its location in the scene file. The loader
/// checks them against the plugin's parameter table before it constructs the object, so getters
/// throw Error only for values that need checks of the plugin's own. Getters return the table's
/// default if the scene doesn't set the parameter. Not thread-safe; used only while a scene is
/// loaded.
class KINOME_EXPORT Properties {
 public:
  using Value = std::variant<bool, int64_t, double, std::string, Vec3, UniformColor, Transform,
                             std::shared_ptr<const Image>, std::shared_ptr<Object>>;
  struct Entry {
    Value value;
    Location where;
    mutable bool read = false;  ///< set by getters, to detect unused parameters
  };

  Properties(Category category, std::string plugin_name, Location where);

  /// Sets the parameter table. The registry calls it before the plugin's constructor.
  void set_table(std::span<const Parameter> table) { table_ = table; }
  /// Adds a parameter. Throws Error if it is set already.
  void set(const std::string& name, Value value, const Location& where);

  Category category() const { return category_; }
  const std::string& plugin_name() const { return plugin_name_; }
  const std::string& id() const { return id_; }
  void set_id(std::string id) { id_ = std::move(id); }
  const Location& where() const { return where_; }
  /// Parameters in file order.
  const std::vector<std::pair<std::string, Entry>>& entries() const { return entries_; }

  /// True if the scene sets the parameter.
  bool has(const std::string& name) const;
  /// True if the scene sets the parameter to a nested object, such as a texture.
  bool has_object(const std::string& name) const;

  /// Throws Error at parameter `name` if the scene also sets `other`.
  void exclude(const std::string& name, const std::string& other) const {
    if (!has(name) || !has(other)) return;
    throw error(name, "can't be combined with '" + other + "': remove one of them");
  }

  /// Value of a parameter: the scene's, or the table's default. All getters throw Error if there is
  /// neither.
  bool boolean(const std::string& name) const;
  int64_t integer(const std::string& name) const;
  /// Returns an integer in [low, high]. Throws Error otherwise.
  uint32_t integer(const std::string& name, uint32_t low, uint32_t high) const;
  float real(const std::string& name) const;
  /// Returns a number for which `is_valid` is true. Throws Error otherwise: `requirement` ("must be
  /// positive") and the number.
  template <class IsValid>
  float real(const std::string& name, const std::string& requirement,
             const IsValid& is_valid) const {
    const float value = real(name);
    if (is_valid(value)) return value;
    throw error(name, requirement + ", got " + format_number(value));
  }
  /// Returns the value of a kFloatOrName parameter: a number, or the value of the named entry in
  /// `names`. Throws Error with the nearest name if the name is unknown.
  float number_or_name(const std::string& name, std::span<const NamedNumber> names) const;
  std::string string(const std::string& name) const;
  /// Returns the path of the file that a kFile parameter names, found in the search paths. Throws
  /// Error with the searched folders if it is missing.
  std::string file(const std::string& name) const;
  Vec3 vector(const std::string& name) const;
  /// Returns a uniform emission in linear Rec.709. <float> is grey; a uniform <spectrum> is
  /// equal-energy white.
  Rgb color(const std::string& name) const;
  /// Returns an affine transform. Default: the identity. Throws Error if it is projective.
  Transform transform(const std::string& name) const;
  /// Returns the <texture>, or a uniform value as a texture; emission is converted as in color().
  /// Returns nullptr only if the parameter is not set and has no default.
  std::shared_ptr<Texture> texture(const std::string& name) const;
  /// Returns the <volume>, or a uniform value as a volume. Returns nullptr only if the parameter is
  /// not set and has no default.
  std::shared_ptr<Volume> volume(const std::string& name) const;
  /// Returns linear pixels passed by a program in place of a file, with one channel or at least
  /// three. Returns nullptr if the parameter is not set.
  std::shared_ptr<const Image> image(const std::string& name) const;
  /// Returns the index of the string in the parameter's choices. Throws Error with a suggestion
  /// otherwise.
  int choice(const std::string& name) const;

  /// A nested object with its name in the scene: "_arg_0", "_arg_1" and so on if it has none.
  template <class T>
  struct Nested {
    std::string name;
    Location where;
    std::shared_ptr<T> object;
  };
  /// Returns all nested objects of class T (Bsdf, Film, …), in file order.
  template <class T>
  std::vector<Nested<T>> nested() const {
    std::vector<Nested<T>> found;
    for (const auto& [name, entry] : entries_) {
      if (const auto* object = std::get_if<std::shared_ptr<Object>>(&entry.value)) {
        if (auto t = std::dynamic_pointer_cast<T>(*object)) {
          entry.read = true;
          found.push_back({name, entry.where, std::move(t)});
        }
      }
    }
    return found;
  }
  /// The same without the names.
  template <class T>
  std::vector<std::shared_ptr<T>> objects() const {
    std::vector<std::shared_ptr<T>> found;
    for (auto& one : nested<T>()) found.push_back(std::move(one.object));
    return found;
  }
  /// Returns the first nested object of class T, or nullptr.
  template <class T>
  std::shared_ptr<T> object() const {
    auto all = objects<T>();
    return all.empty() ? nullptr : all.front();
  }
  /// Returns the nested object of a kObject parameter that is given by name: a named_object(), or a
  /// texture. Returns nullptr if it is optional and not set. Throws Error if it is missing or not a
  /// T.
  template <class T>
  std::shared_ptr<T> object(const std::string& name) const {
    const std::shared_ptr<Object> object = named(name);
    auto t = std::dynamic_pointer_cast<T>(object);
    if (object && !t) throw error(name, "can't be a '" + object->plugin() + "'");
    return t;
  }

  /// Creates an Error located at parameter `name`, or at the object if the scene doesn't set it:
  /// `throw props.error("alpha", "must be positive, got -1")`.
  Error error(const std::string& name, const std::string& message) const;
  /// Logs a warning with the same prefix as error().
  void warn(const std::string& name, const std::string& message) const;

  /// Sets the folders that file() searches, in order. All properties of a scene share them.
  void set_search_paths(std::shared_ptr<const std::vector<std::string>> paths) {
    search_paths_ = std::move(paths);
  }

 private:
  const Entry* find(const std::string& name) const;
  const Parameter& parameter(const std::string& name) const;
  /// Returns the value in the scene, or the table's default.
  Value value(const std::string& name) const;
  /// Returns the object of a kObject parameter, which has the parameter's category. Returns nullptr
  /// if it is optional and not set.
  std::shared_ptr<Object> named(const std::string& name) const;

  Category category_;
  std::string plugin_name_;
  std::string id_;
  Location where_;
  std::span<const Parameter> table_;
  std::vector<std::pair<std::string, Entry>> entries_;
  std::shared_ptr<const std::vector<std::string>> search_paths_;
};

}  // namespace kinome
