// A colour in linear Rec.709, like <rgb>.
//
//   <spectrum type="srgb" name="reflectance"><rgb name="color" value="0.2 0.5 0.8"/></spectrum>

#include "one_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"color", ParameterType::kColorTexture, nullptr, "colour in linear Rec.709", true},
    {"unbounded", ParameterType::kBoolean, "false", "allow values above 1"},
};

class SrgbSpectrum final : public OneColor {
 public:
  explicit SrgbSpectrum(const Properties& props) : OneColor(read(props)) {}

 private:
  static Rgb read(const Properties& props) {
    const auto color = props.texture("color");
    if (!color->is_uniform()) throw props.error("color", "must be a colour, got a texture");
    const Rgb value = not_negative(props, "color", color->mean());
    if (!props.boolean("unbounded") && color->max() > 1) {
      throw props.error("color", "must be between 0 and 1, got " + format_number(color->max()));
    }
    return value;
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::SrgbSpectrum, kinome::Category::kTexture, "srgb",
              "A colour in linear Rec.709.", kinome::kTable);
