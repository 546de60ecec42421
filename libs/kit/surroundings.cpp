#include "kit/subject.h"

#include "kinome/emitter.h"

namespace kinome::check {
namespace {

constexpr const char* kFloor = "<shape type='rectangle'><bsdf type='diffuse'/></shape>";

/// Two rectangles with the BSDF, seen from the front and from the back, and a sphere.
std::string surfaces_of(const std::string& xml) {
  return "<shape type='rectangle'><transform name='to_world'><translate x='-1.1'/></transform>" +
         xml +
         "</shape><shape type='rectangle'><transform name='to_world'><rotate x='1' angle='180'/>"
         "<translate x='1.1'/></transform>" +
         xml + "</shape><shape type='sphere'><point name='center' x='0' y='0' z='1.2'/>" + xml +
         "</shape>";
}

/// A rectangle and a sphere with the emitter, above a floor.
std::string emitters_of(const std::string& xml) {
  return kFloor +
         ("<shape type='rectangle'><transform name='to_world'><scale value='0.6'/><rotate x='1' "
          "angle='130'/><translate x='-0.9' z='1.2'/></transform>" +
          xml + "</shape><shape type='sphere'><point name='center' x='0.9' y='0' z='1'/><float "
                "name='radius' value='0.4'/>" +
          xml + "</shape>");
}

}  // namespace

std::string surroundings(const Subject& subject, const std::string& xml) {
  switch (subject.category()) {
    case Category::kBsdf: return surfaces_of(xml);
    case Category::kEmitter: {
      const auto object = subject.load(xml);
      const auto& emitter = dynamic_cast<const Emitter&>(*object);
      if (emitter.is_surface()) return emitters_of(xml);
      return kFloor + ("<shape type='sphere'><point name='center' x='0' y='0' z='0.5'/><float "
                       "name='radius' value='0.3'/></shape>" +
                       xml);
    }
    default: return "";
  }
}

}  // namespace kinome::check
