#include "kinome/bsdf.h"
#include "kinome/plugin.h"
#include "probe.h"

/// A plugin that distinguishes BSDFs by their names, and takes another one of any name.
namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    named_object("interior", Category::kBsdf, "", true),
    named_object("exterior", Category::kBsdf, ""),
    named_object("mask", Category::kTexture, ""),
    named_object("light", Category::kEmitter, ""),
    {"bsdf", ParameterType::kObject, nullptr, "", false, Category::kBsdf},
};

class Boundary final : public test::Probe {
 public:
  explicit Boundary(const Properties& props) {
    objects = {props.object<Bsdf>("interior"), props.object<Bsdf>("exterior"),
               props.object<Texture>("mask"), props.object<Object>("light")};
    for (const auto& [name, where, bsdf] : props.nested<Bsdf>()) string += name + " ";
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Boundary, kinome::Category::kTexture, "boundary",
              "Distinguishes nested objects by name.", kinome::kTable);
