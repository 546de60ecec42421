/// Shapes in one another's place, as if they stood in the scene themselves. Mitsuba makes one mesh
/// of those of one material, which is faster there; here it makes no difference.
///
///     <shape type="merge">
///       <shape type="cube"/> <shape type="sphere"/>
///     </shape>

#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/shape_group.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"shape", ParameterType::kObject, nullptr, "A shape.", false, Category::kShape, 1000000},
    {"bsdf", ParameterType::kObject, nullptr, "Ignored, as in Mitsuba: the shapes have their own.",
     false, Category::kBsdf},
};

class Merge final : public Shape {
 public:
  explicit Merge(const Properties& props) {
    if (!props.objects<Bsdf>().empty()) {
      log_warn(
          Error(props.where(), "the bsdf of a merge is ignored: its shapes have their own").what());
    }
    for (const auto& shape : props.objects<Shape>()) {
      if (std::dynamic_pointer_cast<ShapeGroup>(shape)) continue;  // its instances show it
      parts_.push_back(shape);
      bounds_.expand(shape->bounds());
    }
  }

  std::vector<std::shared_ptr<Shape>> parts() const override { return parts_; }
  Aabb bounds() const override { return bounds_; }
  // Its parts stand for it.
  SurfaceInteraction interaction(const Ray&, const Hit&) const override { return {}; }
  float area() const override { return 0; }
  SurfaceInteraction sample_surface(const Vec2&) const override { return {}; }

 private:
  std::vector<std::shared_ptr<Shape>> parts_;
  Aabb bounds_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Merge, kinome::Category::kShape, "merge", "Several shapes as one.",
              kinome::kTable);
