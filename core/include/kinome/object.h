#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinome/export.h"

namespace kinome {

/// Plugin category. The names are Mitsuba's tags (`<bsdf type="…">`) and the names of the plugin
/// folders.
enum class Category {
  kBsdf,
  kEmitter,
  kFilm,
  kIntegrator,
  kMedium,
  kPhase,
  kReconstructionFilter,
  kSampler,
  kSensor,
  kShape,
  kTexture,
  kVolume,
};
inline constexpr Category kCategories[] = {Category::kBsdf,
                                           Category::kEmitter,
                                           Category::kFilm,
                                           Category::kIntegrator,
                                           Category::kMedium,
                                           Category::kPhase,
                                           Category::kReconstructionFilter,
                                           Category::kSampler,
                                           Category::kSensor,
                                           Category::kShape,
                                           Category::kTexture,
                                           Category::kVolume};
/// "bsdf", "emitter", "film", "integrator", "medium", "phase", "rfilter", "sampler", "sensor",
/// "shape", "texture", "volume".
KINOME_EXPORT const char* to_string(Category category);
/// Returns nullopt if there is no such category.
KINOME_EXPORT std::optional<Category> category_named(const std::string& name);

/// Base class of all objects that plugins create. An object is constructed once while a scene is
/// loaded, then immutable and shared by all threads while it renders. Const member functions are
/// thread-safe. Objects that read files (ParameterType::kFile) may be constructed by several
/// threads at a time; their constructors must only read shared objects (BSDFs and textures).
class KINOME_EXPORT Object {
 public:
  virtual ~Object();
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  /// Id in the scene, or "".
  const std::string& id() const { return id_; }
  void set_id(std::string id) { id_ = std::move(id); }
  /// "category/name" of the plugin that created the object, and the objects nested in it. The
  /// registry sets both after construction.
  const std::string& plugin() const { return plugin_; }
  const std::vector<std::shared_ptr<const Object>>& nested() const { return nested_; }
  void set_origin(std::string plugin, std::vector<std::shared_ptr<const Object>> nested) {
    plugin_ = std::move(plugin);
    nested_ = std::move(nested);
  }

 protected:
  Object() = default;

 private:
  std::string id_;
  std::string plugin_;
  std::vector<std::shared_ptr<const Object>> nested_;
};

}  // namespace kinome
