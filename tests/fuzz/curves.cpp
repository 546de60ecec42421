// Reads any bytes as a file of curves, of either type.

#include "fuzz.h"
#include "kinome/shape.h"

namespace kinome::fuzz {
namespace {

void load_curves(const std::string& type, const std::string& file) {
  const auto shape = std::dynamic_pointer_cast<Shape>(load_file(Category::kShape, type, file));
  if (!shape) return;
  const CurveSet& curves = *shape->curves();
  const size_t most = curves.is_bspline ? 4 : 2;
  for (const uint32_t first : curves.segments) {
    if (first + most > curves.points.size()) throw std::logic_error("an index out of range");
  }
  for (const glm::vec4& point : curves.points) {
    if (!is_finite(Vec3(point)) || !(point.w > 0)) throw std::logic_error("a broken control point");
  }
}

}  // namespace
}  // namespace kinome::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const kinome::fuzz::InputFile file(".txt");
  const std::string path = file.write(data, size);
  kinome::fuzz::load_curves("linearcurve", path);
  kinome::fuzz::load_curves("bsplinecurve", path);
  return 0;
}
