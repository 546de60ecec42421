#include "kinome/object.h"

namespace kinome {

Object::~Object() = default;

const char* to_string(Category category) {
  switch (category) {
    case Category::kBsdf:
      return "bsdf";
    case Category::kEmitter:
      return "emitter";
    case Category::kFilm:
      return "film";
    case Category::kIntegrator:
      return "integrator";
    case Category::kReconstructionFilter:
      return "rfilter";
    case Category::kSampler:
      return "sampler";
    case Category::kSensor:
      return "sensor";
    case Category::kShape:
      return "shape";
    case Category::kTexture:
      return "texture";
  }
  return "";
}

}  // namespace kinome
