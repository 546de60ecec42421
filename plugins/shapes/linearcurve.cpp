/// Curves made of straight pieces: cones between round joints, each as wide as the radii of its
/// control points say. They are seen from outside only.
///
///     <shape type="linearcurve"><string name="filename" value="twigs.txt"/></shape>

#include "curve_shape.h"

namespace kinome {
namespace {

class LinearCurve final : public CurveShape<false> {
 public:
  using CurveShape::CurveShape;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::LinearCurve, kinome::Category::kShape, "linearcurve",
              "Curves of straight pieces, of round cross section.", kinome::kCurveParameters);
