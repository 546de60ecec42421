/// A copy of a shapegroup's shapes under any affine transform, including mirroring and uneven
/// scales. A copy needs a few hundred bytes, independent of the group's size.
///
///     <shape type="instance">
///       <ref id="tree"/>
///       <transform name="to_world"><scale value="1.2"/><translate x="5"/></transform>
///     </shape>

#include "kinome/plugin.h"
#include "kinome/shape_group.h"
#include "placed_shape.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    kToWorld,
    {"shapegroup", ParameterType::kObject, nullptr, "Shapegroup, or a <ref> to one.", true,
     Category::kShape},
};

class Instance final : public ShapeInstance {
 public:
  explicit Instance(const Properties& props)
      : ShapeInstance(props),
        group_(group_of(props)),
        map_(std::make_shared<const AffineMap>(to_world_of(props))) {
    for (const auto& shape : group_->shapes()) {
      parts_.push_back(std::make_shared<PlacedShape>(shape, map_));
      bounds_.expand(parts_.back()->bounds());
    }
  }

  const ShapeGroup& group() const override { return *group_; }
  const Mat4& to_world() const override { return map_->to_world(); }
  std::vector<std::shared_ptr<Shape>> parts() const override { return parts_; }
  Aabb bounds() const override { return bounds_; }

 private:
  static std::shared_ptr<const ShapeGroup> group_of(const Properties& props) {
    auto group = std::dynamic_pointer_cast<const ShapeGroup>(props.object<Shape>());
    if (!group) throw Error(props.where(), "requires a nested 'shapegroup', got another shape");
    return group;
  }

  std::shared_ptr<const ShapeGroup> group_;
  std::shared_ptr<const AffineMap> map_;
  std::vector<std::shared_ptr<Shape>> parts_;
  Aabb bounds_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Instance, kinome::Category::kShape, "instance",
              "A copy of a shapegroup at another position.", kinome::kTable);
