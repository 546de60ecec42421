#include "kinome/shape.h"

namespace kinome {

Shape::Shape(const Properties& props)
    : bsdf_(props.object<Bsdf>()), emitter_(props.object<Emitter>()) {}

}  // namespace kinome
