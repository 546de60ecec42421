#include "kinome/emitter.h"

#include "kinome/error.h"

namespace kinome {

void Emitter::attach(const Shape& shape) {
  if (shape_) throw Error("an emitter can be part of one shape only; give each shape its own");
  shape_ = &shape;
}

}  // namespace kinome
