// A medium whose extinction is x in the unit cube, except for its fault.

#include "kinome/medium.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {
    KINOME_WRONG_PARAMETER,
    {"phase", ParameterType::kObject, nullptr, "Its phase function.", false, Category::kPhase},
};

class WrongMedium final : public Medium {
 public:
  explicit WrongMedium(const Properties& props) : wrong_(props) {
    phase_ = props.object<Phase>();
    max_extinction_ = wrong_.or_wrong("max", 1.f, 0.8f);
  }

  MediumCoefficients coefficients(const Vec3& p, const Vec3& /*d*/) const override {
    Rgb extinction(p.x);
    if (wrong_.is("coloured")) extinction.y *= 0.9f;
    return {extinction, extinction * wrong_.or_wrong("albedo", 0.5f, 1.5f)};
  }
  void coefficients_block(const Columns3& p, const Columns3& d, size_t count,
                          const MediumBlock& out) const override {
    Medium::coefficients_block(p, d, count, out);
    for (size_t i = 0; wrong_.is("block") && out.scattering.x && i < count; ++i) {
      out.scattering.z[i] *= 0.9f;
    }
  }
  Aabb box() const override { return {Vec3(0.f), Vec3(1.f)}; }
  bool is_uniform() const override { return wrong_.is("uniform"); }
  void extremes(const BlockGrid& blocks, float* lo, float* hi) const override {
    Medium::extremes(blocks, lo, hi);
    for (size_t i = 0; wrong_.is("extremes") && i < blocks.count(); ++i) lo[i] = 0.3f;
  }
  bool has_optical_depth() const override { return true; }
  void optical_depth_block(const Columns3& o, const Columns3& d, const float* length, size_t count,
                           const Columns3& out) const override {
    for (size_t i = 0; i < count; ++i) {
      const float middle = o.x[i] + d.x[i] * length[i] * wrong_.or_wrong("depth", 0.5f, 1.f);
      out.set(i, Vec3(middle * length[i]));
    }
  }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongMedium, kinome::Category::kMedium, "wrong", "Has a fault.",
              kinome::test::kTable);
