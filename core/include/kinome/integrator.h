#pragma once

#include <string>
#include <vector>

#include "kinome/inspection.h"
#include "kinome/math.h"
#include "kinome/object.h"

namespace kinome {

class RenderContext;
class Scene;
class Sensor;

/// Turns a scene into pixels. Never sees threads: it is handed tiles.
class KINOME_EXPORT Integrator : public Object {
 public:
  /// Film layers that render() fills (Film::prepare): the first lists channels beside the film's
  /// colour, the others stand alone.
  virtual std::vector<std::vector<std::string>> layers() const { return {{}}; }
  /// Emitter plugin that the scene is given where it has no indirect emitter (Emitter::is_indirect)
  /// of its own; nullptr: it has no use for any, and the loader warns of those that the scene has.
  virtual const char* default_indirect_emitter() const { return nullptr; }
  /// Fills the sensor's film, which the caller has prepared. Returns early, with what it has, where
  /// the context is cancelled.
  virtual void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const = 0;
  /// How the light of what is seen by the first sample of the pixel that `film_position` lies in is
  /// chosen, for each set of light points; for people to look at. Error where nothing is seen, or
  /// the integrator doesn't choose.
  virtual std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor,
                                          RenderContext& context, const Vec2& film_position) const;
};

}  // namespace kinome
