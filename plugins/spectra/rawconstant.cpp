// One number or three, used without any conversion.
//
//   <texture type="rawconstant" name="alpha"><float name="value" value="0.3"/></texture>
//   <texture type="rawconstant" name="eta"><vector name="value" value="0.2 0.9 1.1"/></texture>

#include "one_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"value", ParameterType::kColorTexture, nullptr, "a float, or a vector of three floats", true},
};

class RawConstant final : public OneColor {
 public:
  explicit RawConstant(const Properties& props) : OneColor(read(props)) {}

 private:
  static Rgb read(const Properties& props) {
    const auto value = props.texture("value");
    if (!value->is_uniform()) {
      throw props.error("value", "must be one number or three, got a texture");
    }
    return value->mean();
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RawConstant, kinome::Category::kTexture, "rawconstant",
              "One number or three, used without conversion.", kinome::kTable);
