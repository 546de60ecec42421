// Daylight (D65): in RGB white, times a factor and a colour; or the texture that is nested in it,
// whose colours are meant to be seen as light of that white. As in Mitsuba 3, `scale` means nothing
// to a nested texture.
//
//   <spectrum type="d65" name="radiance"><float name="scale" value="2"/></spectrum>

#include "one_color.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    {"color", ParameterType::kColorTexture, "1", "linear Rec.709"},
    {"scale", ParameterType::kFloat, "1", "factor of the colour; not negative"},
    {"texture", ParameterType::kObject, nullptr, "in place of color and scale", false,
     Category::kTexture},
};

class Daylight final : public OneColor {
 public:
  explicit Daylight(const Properties& props) : OneColor(read(props)) {}

 private:
  static std::shared_ptr<Texture> read(const Properties& props) {
    const float scale = not_negative(props, "scale", Rgb(props.real("scale"))).x;
    if (const auto texture = props.object<Texture>()) {
      if (scale != 1) props.warn("scale", "means nothing beside a texture, as in Mitsuba 3");
      return texture;
    }
    const Rgb color = props.texture("color")->mean();
    return make_uniform_texture(scale * not_negative(props, "color", color));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Daylight, kinome::Category::kTexture, "d65",
              "Daylight: white, times a colour; or a texture as light.", kinome::kTable);
