#include "kinome/object.h"

#include <iterator>

namespace kinome {

Object::~Object() = default;

const char* to_string(Category category) {
  constexpr const char* kNames[] = {"bsdf",  "emitter", "film",    "integrator",
                                    "medium", "phase",  "rfilter", "sampler",
                                    "sensor", "shape",  "texture", "volume"};
  static_assert(std::size(kNames) == std::size(kCategories));
  return kNames[static_cast<size_t>(category)];
}

std::optional<Category> category_named(const std::string& name) {
  for (const Category category : kCategories) {
    if (name == to_string(category)) return category;
  }
  return std::nullopt;
}

}  // namespace kinome
