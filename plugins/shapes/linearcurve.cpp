/// Curves of straight segments: cones between spherical joints, with the radii of the control
/// points. Only visible from outside.
///
///     <shape type="linearcurve"><string name="filename" value="twigs.txt"/></shape>

#include "curve_shape.h"

KINOME_PLUGIN(kinome::CurveShape<false>, kinome::Category::kShape, "linearcurve",
              "Curves of straight segments with a round cross section.", kinome::kCurveParameters);
