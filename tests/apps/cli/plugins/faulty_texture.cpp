// A texture with a fault, for tests of the program's reaction.

#include "faulty.h"
#include "kinome/texture.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_FAULT_PARAMETER};

/// Crashes while its library is loaded.
const bool crashes_at_once = [] {
  if (std::getenv("KINOME_TEST_CRASH")) raise(SIGSEGV);
  return false;
}();

/// Grey, except for its fault.
class FaultyTexture final : public Texture {
 public:
  explicit FaultyTexture(const Properties& props) : fault_(props) {}

  Rgb eval(const Vec2& /*uv*/) const override {
    fault_.throw_if("eval", "be looked up");
    return Rgb(fault_.is("nan") ? kNan : 0.5f);
  }
  Rgb mean() const override { return Rgb(0.5f); }
  float max() const override { return 0.5f; }
  float min() const override { return 0.5f; }

 private:
  Fault fault_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::FaultyTexture, kinome::Category::kTexture, "faulty", "Has a fault.",
              kinome::test::kTable);
