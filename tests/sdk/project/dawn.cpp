// A glow along the horizon, as an example of the shortest environment.
//
//     <emitter type="dawn"> <rgb name="colour" value="1 .5 .2"/> </emitter>

#include <cmath>

#include <kinome/plugin.h>
#include <kinome/sky.h>

struct Dawn final : kinome::Sky {
  explicit Dawn(const kinome::Properties& props) : colour(props.color("colour")) {}
  kinome::Rgb radiance(const kinome::Vec3& d) const override {
    return colour * std::exp(-8 * std::abs(d.y));
  }
  kinome::Rgb colour;
};

constexpr kinome::Parameter kParameters[] = {
    {"colour", kinome::ParameterType::kEmission, "1 .6 .3", "Radiance at the horizon."},
};
KINOME_PLUGIN(Dawn, kinome::Category::kEmitter, "dawn", "A glow along the horizon.", kParameters);
