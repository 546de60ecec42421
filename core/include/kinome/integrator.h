#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kinome/film.h"
#include "kinome/inspection.h"
#include "kinome/math.h"
#include "kinome/object.h"

namespace kinome {

class RenderContext;
struct Stage;
class Scene;
class Sensor;

/// A picture in the making: passes over all of it that add up in the sensor's film, each an
/// unbiased estimate of its own, weighed by its number of samples. Nothing is weighed, or left out,
/// by what it found. Memory doesn't grow with their number.
class KINOME_EXPORT Passes {
 public:
  virtual ~Passes() = default;
  /// Samples that the scene asks for, in the unit of render().
  virtual double samples() const = 0;
  /// Adds a pass of about that many samples a pixel, at least 1, as Sampler::sample_count counts
  /// them, or of what costs as much; returns what it was. Random numbers are none that an earlier
  /// pass has used. Cut short where the context is cancelled. Progress within the pass is 0 to 1.
  virtual double render(double samples) = 0;
  /// Expected, before any pass: what a sample of all pixels takes; 0: there is no telling.
  virtual double seconds_per_sample() const { return 0; }
};

/// Turns a scene into pixels. Never sees threads: it is handed tiles.
class KINOME_EXPORT Integrator : public Object {
 public:
  /// Film layers that render() fills (Film::prepare): the first lists channels beside the film's
  /// colour, the others stand alone.
  virtual std::vector<std::vector<std::string>> layers() const { return {{}}; }
  /// What the picture shows of them beside the film's colour: by default the values that have names.
  virtual std::vector<FilmChannel> channels() const { return channels_of(layers()); }
  /// The film is given each sample by itself, not what several have come to: so that it can take the
  /// mean of their squares.
  virtual bool gives_samples() const { return true; }
  /// The stages of render(), in the order in which they run, for tables of times: those that aren't
  /// among them are shown by their names alone. By default kPrimaryStage and kFilmStage.
  virtual std::vector<Stage> stages() const;
  /// Emitter plugin that the scene is given where it has no indirect emitter (Emitter::is_indirect)
  /// of its own; nullptr: it has no use for any, and the loader warns of those that the scene has.
  virtual const char* default_indirect_emitter() const { return nullptr; }
  /// Warns of light that is asked for and that render() leaves out, where it shows. Called once,
  /// before the picture is begun.
  virtual void warn_of_light_left_out(const Scene& /*scene*/, const Sensor& /*sensor*/,
                                      RenderContext& /*context*/) const {}
  /// Fills the sensor's film, which the caller has prepared. Returns early, with what it has, where
  /// the context is cancelled.
  virtual void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const = 0;
  /// For budgets that aren't a number of samples. `seconds` is the time that there will be,
  /// infinite where it has no limit: it may be used to prepare, sparingly. By default each pass is
  /// a render() with a seed and a number of samples of its own.
  virtual std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor,
                                        RenderContext& context, double seconds) const;
  /// How the light of what is seen by the first sample of the pixel that `film_position` lies in is
  /// chosen, for each set of light points; for people to look at. Error where nothing is seen, or
  /// the integrator doesn't choose.
  virtual std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor,
                                          RenderContext& context, const Vec2& film_position) const;
};

}  // namespace kinome
