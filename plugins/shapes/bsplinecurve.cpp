/// Smooth curves such as hair: uniform cubic B-splines with a round cross section. Only visible
/// from outside, and without caps.
///
///     <shape type="bsplinecurve"><string name="filename" value="hair.txt"/></shape>

#include "curve_shape.h"

KINOME_PLUGIN(kinome::CurveShape<true>, kinome::Category::kShape, "bsplinecurve",
              "Smooth curves with a round cross section.", kinome::kCurveParameters);
