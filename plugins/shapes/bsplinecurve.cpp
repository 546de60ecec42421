/// Smooth curves such as hair: uniform cubic B-splines with a round cross section. Only visible
/// from outside, and without caps.
///
///     <shape type="bsplinecurve"><string name="filename" value="hair.txt"/></shape>

#include "curve_shape.h"

namespace kinome {
namespace {

class BSplineCurve final : public CurveShape<true> {
 public:
  using CurveShape::CurveShape;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::BSplineCurve, kinome::Category::kShape, "bsplinecurve",
              "Smooth curves with a round cross section.", kinome::kCurveParameters);
