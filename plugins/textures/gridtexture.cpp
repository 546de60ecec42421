#include "two_colors.h"

/// Lines at integer u and v, as in Mitsuba 0.6.
///
///     <texture type="gridtexture" name="reflectance">
///       <rgb name="color0" value="0.8"/><rgb name="color1" value="0.1"/>
///       <float name="line_width" value="0.05"/>
///       <transform name="to_uv"><scale value="10"/></transform>
///     </texture>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"color0", ParameterType::kColorTexture, "0.2", "colour between the lines"},
    {"color1", ParameterType::kColorTexture, "0.4", "colour of the lines"},
    {"line_width", ParameterType::kFloat, "0.01", "half of the width of a line"},
    {"to_uv", ParameterType::kTransform, "identity",
     "transform from surface to texture coordinates"},
};

struct Grid {
  static constexpr bool kSwapsNumbers = false;
  float line_width;

  float share_of_first() const {
    const float side = std::clamp(1 - 2 * line_width, 0.f, 1.f);
    return side * side;
  }

  template <class F>
  MaskOf<F> is_first(const Vec2Of<F>& p) const {
    const F u = abs(p.x - floor(p.x + 0.5f)), v = abs(p.y - floor(p.y + 0.5f));
    return u >= line_width && v >= line_width;
  }
};

class GridTexture final : public TwoColors<Grid> {
 public:
  explicit GridTexture(const Properties& props)
      : TwoColors(props, Grid{props.real("line_width", "must not be negative",
                                         [](float width) { return width >= 0; })}) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::GridTexture, kinome::Category::kTexture, "gridtexture",
              "Lines at integer u and v, as in Mitsuba 0.6.", kinome::kParameters);
