#include "kinome/plugin.h"
#include "probe.h"

/// Says what it is built for.
namespace kinome {
namespace {

class WideProbe final : public test::Probe {
 public:
  explicit WideProbe(const Properties&) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::WideProbe, kinome::Category::kTexture, "wide_probe", KINOME_ABI_ISA, {});
