// A density that falls with the height y, exp(-y / height), in the unit cube:
//
//     <volume type="haze" name="sigma_t"> <float name="height" value="0.3"/> </volume>

#include <cmath>

#include <kinome/plugin.h>
#include <kinome/volume.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"height", ParameterType::kFloat, "0.3", "Height at which the density is 1 / e; positive."},
};

class Haze final : public Volume {
 public:
  explicit Haze(const Properties& props)
      : height_(props.real("height", "must be between 0.01 and 100",
                           [](float height) { return height >= 0.01f && height <= 100; })) {}

  uint32_t channels() const override { return 1; }
  void eval(const Vec3& p, float* values) const override { values[0] = density(p.y); }
  float min() const override { return density(1); }
  float max() const override { return 1; }
  Aabb box() const override { return {Vec3(0.f), Vec3(1.f)}; }

  // Without these two functions, media would use min() and max() everywhere.
  glm::uvec3 resolution() const override { return {1, 64, 1}; }
  void extremes(const BlockGrid& blocks, float* lo, float* hi) const override {
    glm::uvec3 at(0);
    for (size_t i = 0; i < blocks.count(); ++i) {
      at.y = static_cast<uint32_t>(i / blocks.size.x) % blocks.size.y;
      const Aabb block = blocks.block(at);
      lo[i] = density(block.hi.y);
      hi[i] = density(block.lo.y);
    }
  }

 private:
  /// Constant below 0 and above 1.
  float density(float y) const { return std::exp(-std::min(std::max(y, 0.f), 1.f) / height_); }

  float height_;
};

}  // namespace

KINOME_PLUGIN(Haze, Category::kVolume, "haze", "A density that falls exponentially with y.",
              kParameters);
