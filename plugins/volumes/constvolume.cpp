#include "kinome/plugin.h"
#include "kinome/texture.h"
#include "kinome/volume.h"

/// The same value everywhere. A heterogeneous medium still ends at the unit cube that `to_world`
/// transforms.
///
///     <volume type="constvolume" name="albedo"><rgb name="value" value="0.9 0.8 0.7"/></volume>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"value", ParameterType::kColorTexture, "1", "the value; textures must be uniform"},
    {"to_world", ParameterType::kTransform, "identity", "transform of the unit cube"},
};

Rgb uniform_value(const Properties& props) {
  const auto texture = props.texture("value");
  if (!texture->is_uniform())
    throw props.error("value", "must be uniform, got a texture that varies");
  return texture->mean();
}

Aabb box_of(const Transform& to_world) {
  Aabb box;
  for (unsigned i = 0; i < 8; ++i) {
    box.expand(to_world.point(Aabb(Vec3(0.f), Vec3(1.f)).corner(i)));
  }
  return box;
}

class ConstVolume final : public UniformVolume {
 public:
  explicit ConstVolume(const Properties& props)
      : UniformVolume(uniform_value(props), box_of(props.transform("to_world"))) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::ConstVolume, kinome::Category::kVolume, "constvolume",
              "The same value everywhere.", kinome::kParameters);
