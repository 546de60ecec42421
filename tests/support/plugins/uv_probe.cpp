#include "kinome/plugin.h"
#include "probe.h"

/// A plugin with a to_uv parameter, as bitmap and checkerboard have.
namespace kinome {
namespace {

constexpr Parameter kTable[] = {{"to_uv", ParameterType::kTransform, nullptr, ""}};

class UvProbe final : public test::Probe {
 public:
  explicit UvProbe(const Properties& props) { transform = props.transform("to_uv"); }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::UvProbe, kinome::Category::kTexture, "uv_probe", "A probe of to_uv.",
              kinome::kTable);
