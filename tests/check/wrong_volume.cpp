// A ramp along x in the unit cube, except for its fault.

#include <algorithm>

#include "kinome/volume.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_WRONG_PARAMETER};

class WrongVolume final : public Volume {
 public:
  explicit WrongVolume(const Properties& props) : wrong_(props) {}

  uint32_t channels() const override { return wrong_.or_wrong("channels", 1u, 2u); }
  void eval(const Vec3& p, float* values) const override {
    std::fill_n(values, channels(), std::clamp(p.x, 0.f, 1.f));
  }
  void eval_block(const Columns3& p, size_t count, float* const* values) const override {
    Volume::eval_block(p, count, values);
    for (size_t i = 0; wrong_.is("block") && i < count; ++i) values[0][i] *= 0.9f;
  }
  float min() const override { return 0; }
  float max() const override { return wrong_.or_wrong("max", 1.f, 0.8f); }
  Aabb box() const override { return {Vec3(0.f), Vec3(1.f)}; }
  void extremes(const BlockGrid& blocks, float* lo, float* hi) const override {
    Volume::extremes(blocks, lo, hi);
    if (wrong_.is("extremes")) hi[blocks.count() - 1] = 0.5f;
  }
  bool has_integral() const override { return wrong_.is("integral"); }
  void integral_block(const Columns3& o, const Columns3& /*d*/, const float* length, size_t count,
                      float* const* values) const override {
    for (size_t i = 0; i < count; ++i) values[0][i] = o.x[i] * length[i];
  }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongVolume, kinome::Category::kVolume, "wrong", "Has a fault.",
              kinome::test::kTable);
