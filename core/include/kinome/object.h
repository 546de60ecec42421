#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kinome/export.h"

namespace kinome {

/// What a plugin can be. The names are Mitsuba's tags (`<bsdf type="…">`) and the names of the
/// folders that plugins are found in.
enum class Category {
  kBsdf,
  kEmitter,
  kFilm,
  kIntegrator,
  kReconstructionFilter,
  kSampler,
  kSensor,
  kShape,
  kTexture,
};
inline constexpr int kCategoryCount = 9;
/// "bsdf", "emitter", "film", "integrator", "rfilter", "sampler", "sensor", "shape", "texture".
KINOME_EXPORT const char* to_string(Category category);

/// Anything that a plugin makes. Constructed once while a scene loads, immutable and shared by all
/// threads while it renders (const member functions are thread-safe).
class KINOME_EXPORT Object {
 public:
  virtual ~Object();
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  /// The scene's name for it, or "".
  const std::string& id() const { return id_; }
  void set_id(std::string id) { id_ = std::move(id); }
  /// "category/name" of the plugin that made it, and the objects that the scene nests in it; set by
  /// the registry once it is made.
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
