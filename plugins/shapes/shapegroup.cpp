/// A group of shapes for `instance`, which places copies of it in the scene. The group itself isn't
/// visible. Its shapes are stored only once.
///
///     <shape type="shapegroup" id="tree">
///       <shape type="ply"><string name="filename" value="trunk.ply"/></shape>
///       <shape type="ply"><string name="filename" value="leaves.ply"/></shape>
///     </shape>
///     <shape type="instance"><ref id="tree"/></shape>

#include "kinome/plugin.h"
#include "kinome/shape_group.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"shape", ParameterType::kObject, nullptr, "The shapes, which must not emit.", false,
     Category::kShape, 1000000},
    ignored_row("to_world", ParameterType::kTransform, "instances have their own"),
};

using Group = ShapeGroup;

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Group, kinome::Category::kShape, "shapegroup",
              "A group of shapes that instances place in the scene.", kinome::kTable);
