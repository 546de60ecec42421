/// Several shapes, as if each were in the scene itself. Mitsuba merges shapes with the same
/// material into one mesh, which renders faster there. In Kinome, it makes no difference.
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
    {"shape", ParameterType::kObject, nullptr, "The shapes.", false, Category::kShape, 1000000},
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
      if (std::dynamic_pointer_cast<ShapeGroup>(shape)) continue;  // only visible by its instances
      parts_.push_back(shape);
      bounds_.expand(shape->bounds());
    }
  }

  std::vector<std::shared_ptr<Shape>> parts() const override { return parts_; }
  Aabb bounds() const override { return bounds_; }
  // Never called: the scene uses the parts.
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
