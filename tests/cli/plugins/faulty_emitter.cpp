#include "faulty.h"
#include "kinome/emitter.h"
#include "kinome/warp.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_FAULT_PARAMETER};

/// An even sky but for its fault.
class FaultyEmitter final : public Emitter {
 public:
  explicit FaultyEmitter(const Properties& props) : fault_(props) {}

  bool is_environment() const override { return true; }
  Rgb eval_environment(const Vec3& d) const override {
    fault_.throw_if("eval", "shine");
    return Rgb(fault_.is("nan") && d.y > 0.5f ? kNan : 1.f);
  }
  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& u) const override {
    DirectSample sample;
    sample.d = square_to_uniform_sphere(u);
    sample.pdf = pdf_environment(sample.d);
    sample.radiance = eval_environment(sample.d);
    return sample;
  }
  float pdf_environment(const Vec3& /*d*/) const override {
    return (fault_.is("negative pdf") ? -1 : 1) / (4 * kPi);
  }

 private:
  Fault fault_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::FaultyEmitter, kinome::Category::kEmitter, "faulty", "Has a fault.",
              kinome::test::kTable);
