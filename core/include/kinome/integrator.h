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

/// Progressive render: passes over the whole image that accumulate in the sensor's film. Each pass
/// is an unbiased estimate by itself, weighted by its number of samples. No pass is weighted or
/// dropped because of its result. Memory doesn't grow with the number of passes.
class KINOME_EXPORT Passes {
 public:
  virtual ~Passes() = default;
  /// Samples per pixel that the scene requests, in the unit of render().
  virtual double samples() const = 0;
  /// Adds a pass of about `samples` samples per pixel (at least 1; see Sampler::sample_count()), or
  /// of equal cost. Returns the number rendered. Each pass uses new random numbers, and stops early
  /// if the context is cancelled. Progress runs from 0 to 1 within the pass.
  virtual double render(double samples) = 0;
  /// Expected seconds per sample of all pixels, before the first pass; 0 if unknown.
  virtual double seconds_per_sample() const { return 0; }
};

/// Renders a scene into a film. Integrators create no threads; they loop over tiles or items with
/// the scheduler.
class KINOME_EXPORT Integrator : public Object {
 public:
  /// Film layers that render() fills (see Film::prepare()). The first layer lists channels beside
  /// the film's colour; the other layers are independent.
  virtual std::vector<std::vector<std::string>> layers() const { return {{}}; }
  /// Image channels beside the film's colour. Default: one for each named value of the layers.
  virtual std::vector<FilmChannel> channels() const { return channels_of(layers()); }
  /// True if render() adds every sample to the film separately, not averages of samples, so that
  /// the film can average squared samples.
  virtual bool gives_samples() const { return true; }
  /// Stages of render() in order of execution, for time tables. Stages that are not listed appear
  /// by their names only. Default: kPrimaryStage and kFilmStage.
  virtual std::vector<Stage> stages() const;
  /// Emitter plugin that the loader adds to scenes without an indirect emitter
  /// (Emitter::is_indirect()). Returns nullptr if the integrator doesn't use indirect emitters; the
  /// loader then warns about those in the scene.
  virtual const char* default_indirect_emitter() const { return nullptr; }
  /// True if render() handles media. Otherwise, the loader warns that it ignores the scene's.
  virtual bool traces_media() const { return false; }
  /// Warns about emitters or light paths in the scene that render() ignores. Called once before
  /// rendering.
  virtual void warn_of_ignored_light(const Scene& /*scene*/, const Sensor& /*sensor*/,
                                     RenderContext& /*context*/) const {}
  /// Renders into the sensor's film, which the caller has prepared. Returns early with the samples
  /// so far if the context is cancelled.
  virtual void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const = 0;
  /// Begins a progressive render, for budgets of time or error. `seconds` is the available time,
  /// possibly infinite; preparation should take only a small part of it. Default: each pass calls
  /// render() with a seed and a sample count of its own.
  virtual std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor,
                                        RenderContext& context, double seconds) const;
  /// Reports, for each set of light points, how lights are chosen at the surface seen by the first
  /// sample of the pixel at `film_position`; for inspection by users. Throws Error if no surface is
  /// seen, or the integrator doesn't support it.
  virtual std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor,
                                          RenderContext& context, const Vec2& film_position) const;
};

/// Warns if the scene has no emitter, for integrators that show only emitted light.
KINOME_EXPORT void warn_without_emitters(const Scene& scene);

}  // namespace kinome
