// Daylight (D65), which is white in RGB, times a factor and a colour. With a nested texture, its
// colours are used unchanged as emission relative to D65. As in Mitsuba 3, `scale` is ignored then.
//
//   <spectrum type="d65" name="radiance"><float name="scale" value="2"/></spectrum>

#include "one_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"color", ParameterType::kColorTexture, "1", "colour in linear Rec.709"},
    {"scale", ParameterType::kFloat, "1", "scale factor of the colour; not negative"},
    {"texture", ParameterType::kObject, nullptr, "texture; alternative to color and scale", false,
     Category::kTexture},
};

class Daylight final : public OneColor {
 public:
  explicit Daylight(const Properties& props) : OneColor(read(props)) {}

 private:
  static std::shared_ptr<Texture> read(const Properties& props) {
    const float scale = not_negative(props, "scale", Rgb(props.real("scale"))).x;
    if (const auto texture = props.object<Texture>()) {
      if (scale != 1) props.warn("scale", "is ignored with a texture, as in Mitsuba 3");
      return texture;
    }
    const Rgb color = props.texture("color")->mean();
    return make_uniform_texture(scale * not_negative(props, "color", color));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Daylight, kinome::Category::kTexture, "d65",
              "Daylight: white times a colour, or a texture used as emission.", kinome::kTable);
