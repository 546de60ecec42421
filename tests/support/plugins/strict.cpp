#include "kinome/plugin.h"
#include "probe.h"

/// A plugin whose parameters are mandatory.
namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"needed", ParameterType::kString, nullptr, "", true},
    {"film", ParameterType::kObject, nullptr, "", true, Category::kFilm},
};

class Strict final : public test::Probe {
 public:
  explicit Strict(const Properties& props) { string = props.string("needed"); }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Strict, kinome::Category::kTexture, "strict", "Needs what it needs.",
              kinome::kTable);
