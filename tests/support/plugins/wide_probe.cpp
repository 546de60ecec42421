#include "kinome/plugin.h"
#include "probe.h"

/// Reports the instruction set for which it is built.
namespace kinome {
namespace {

class WideProbe final : public test::Probe {
 public:
  explicit WideProbe(const Properties&) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::WideProbe, kinome::Category::kTexture, "wide_probe", KINOME_ABI_ISA, {});
