// Mist that thins with the height y: its extinction is density exp(-y / height). The transmittance
// along a ray is known exactly.
//
//     <medium type="mist" name="interior"> <float name="density" value="2"/> </medium>

#include <cmath>

#include <kinome/medium.h>
#include <kinome/plugin.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"density", ParameterType::kFloat, "2", "Extinction at y = 0, per unit of length."},
    {"height", ParameterType::kFloat, "0.5", "Height at which the extinction is 1 / e of that."},
    {"albedo", ParameterType::kFloat, "0.9", "Scattered fraction, in [0,1]."},
    {"phase", ParameterType::kObject, nullptr, "Phase function; default: isotropic.", false,
     Category::kPhase},
};

class Mist final : public Medium {
 public:
  explicit Mist(const Properties& props)
      : density_(props.real("density", "must be from 0 to 1e6",
                            [](float density) { return density >= 0 && density <= 1e6f; })),
        height_(props.real("height", "must be from 0.01 to 100",
                           [](float height) { return height >= 0.01f && height <= 100; })),
        albedo_(props.real("albedo", "must be in [0,1]",
                           [](float albedo) { return albedo >= 0 && albedo <= 1; })) {
    phase_ = props.object<Phase>();  // the loader adds a missing one
    min_extinction_ = extinction(kTop);
    max_extinction_ = extinction(0);
  }

  MediumCoefficients coefficients(const Vec3& p, const Vec3& /*d*/) const override {
    const float sigma_t = p.y >= 0 && p.y <= kTop ? extinction(p.y) : 0.f;
    return {Rgb(sigma_t), Rgb(sigma_t * albedo_)};
  }
  Aabb box() const override { return {Vec3(-kTop, 0, -kTop), Vec3(kTop, kTop, kTop)}; }
  // Mist has no voxels. This number makes the bounds of extremes() narrow.
  glm::uvec3 resolution() const override { return {1, 64, 1}; }
  void extremes(const BlockGrid& blocks, float* lo, float* hi) const override {
    glm::uvec3 at(0);
    for (size_t i = 0; i < blocks.count(); ++i) {
      at.y = static_cast<uint32_t>(i / blocks.size.x) % blocks.size.y;
      const Aabb block = blocks.block(at);
      lo[i] = extinction(block.hi.y);
      hi[i] = extinction(block.lo.y);
    }
  }

  bool has_optical_depth() const override { return true; }
  // The integral of exp(-(y + t dy) / height) over t.
  void optical_depth_block(const Columns3& o, const Columns3& d, const float* length, size_t count,
                           const Columns3& out) const override {
    for (size_t i = 0; i < count; ++i) {
      const float x = d.y[i] * length[i] / height_;
      const float mean = std::abs(x) < 1e-4f ? 1 - x / 2 : -std::expm1(-x) / x;
      out.set(i, Vec3(extinction(o.y[i]) * length[i] * mean));
    }
  }

 private:
  static constexpr float kTop = 10;
  float extinction(float y) const { return density_ * std::exp(-y / height_); }

  float density_, height_, albedo_;
};

}  // namespace

KINOME_PLUGIN(Mist, Category::kMedium, "mist", "Mist that thins with the height.", kParameters);
