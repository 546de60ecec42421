#include "session/put_objects.h"

namespace kinome::viewer {
namespace {

ObjectDescription texture(const std::string& plugin, const std::string& name = "") {
  return {.tag = "texture", .type = plugin, .name = name, .where = Location{plugin}};
}

ObjectDescription image(const std::string& file, bool is_raw, const std::string& name = "") {
  ObjectDescription description = texture("bitmap", name);
  description.values.push_back({"filename", file, description.where});
  if (is_raw) description.values.push_back({"raw", true, description.where});
  return description;
}

ObjectDescription around(const std::string& plugin, ObjectDescription map) {
  return {.tag = "bsdf", .type = plugin, .where = Location{plugin}, .parts = {std::move(map)}};
}

}  // namespace

ObjectDescription bitmap(const std::string& file, ParameterType type) {
  return image(file, type == ParameterType::kUnitlessTexture);
}

ObjectDescription checkerboard() {
  return texture("checkerboard");
}

ObjectDescription normal_map(const std::string& file) {
  return around("normalmap", image(file, true, "normalmap"));
}

ObjectDescription bump_map(const std::string& file) {
  return around("bumpmap", image(file, true, "texture"));
}

}  // namespace kinome::viewer
