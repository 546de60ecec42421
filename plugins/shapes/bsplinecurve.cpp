/// Smooth curves, hair for instance: uniform cubic B-splines of round cross section. They are seen
/// from outside only, and have no caps.
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
              "Smooth curves of round cross section.", kinome::kCurveParameters);
