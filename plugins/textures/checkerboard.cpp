#include "two_colors.h"

/// Two colours in squares of half a unit of (u, v), as in Mitsuba 3. The colour is color0 if both
/// coordinates are in the same half. If the texture is read as a single number (such as a
/// roughness), Mitsuba swaps the two colours. This does the same, because scenes are designed to
/// look right in Mitsuba.
///
///     <texture type="checkerboard" name="reflectance">
///       <rgb name="color0" value="0.8 0.1 0.1"/><float name="color1" value="0.1"/>
///       <transform name="to_uv"><scale value="10"/></transform>
///     </texture>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"color0", ParameterType::kColorTexture, "0.4", "first colour"},
    {"color1", ParameterType::kColorTexture, "0.2", "second colour"},
    {"to_uv", ParameterType::kTransform, "identity",
     "transform from surface to texture coordinates"},
};

struct Squares {
  static constexpr bool kSwapsNumbers = true;
  float share_of_first() const { return 0.5f; }

  template <class F>
  MaskOf<F> is_first(const Vec2Of<F>& p) const {
    const MaskOf<F> upper_u = p.x - floor(p.x) > 0.5f;
    const MaskOf<F> upper_v = p.y - floor(p.y) > 0.5f;
    return !(upper_u ^ upper_v);
  }
};

class Checkerboard final : public TwoColors<Squares> {
 public:
  explicit Checkerboard(const Properties& props) : TwoColors(props, Squares()) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Checkerboard, kinome::Category::kTexture, "checkerboard",
              "Squares of two colours.", kinome::kParameters);
