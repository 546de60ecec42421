#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinome/emitter.h"
#include "kit/statistics/density_cells.h"
#include "kit/subject.h"

namespace kinome::check {

/// The checked emitter in a scene. Also returns reference values for its samples, computed with its
/// other functions.
class EmitterScene {
 public:
  /// `index`: index among the scene's emitters of this plugin.
  explicit EmitterScene(const Subject& subject, int index = 0);
  /// Uses the emitter of this XML element instead of the checked one.
  EmitterScene(const Subject& subject, const std::string& xml, int index);
  /// Number of emitters of the plugin in the scene: surface emitters are on two kinds of shapes.
  static int count(const Subject& subject);

  const Scene& scene() const { return *scene_; }
  const Emitter& emitter() const { return *emitter_; }
  /// Returns a random point that the emitter may light.
  Vec3 random_point(Random& random) const;

  /// Density of the direction d at p. For surfaces, the sum over all their points in this
  /// direction.
  double pdf_along(const Vec3& p, const Vec3& d) const;
  /// Density at the sampled point only; nullopt if a ray doesn't find this point.
  std::optional<float> pdf_of(const Vec3& p, const DirectSample& sample) const;
  bool is_surface() const { return is_surface_; }
  const char* pdf_name() const { return is_surface_ ? "pdf_surface()" : "pdf_environment()"; }
  const char* value_name() const;

  /// Returns a direction of emitted light, and an estimate of the power, as in
  /// EmissionSample::power (times pdf_position for light from infinitely far). `o`: origin of the
  /// light of other emitters.
  std::pair<Vec3, Rgb> reference_emission(Random& random, const Vec3& o);

 private:
  /// Cone around all directions of emitted light, with a uniform density.
  class EmissionCone {
   public:
    explicit EmissionCone(const Emitter& emitter);
    Vec3 direction(Random& random) const;
    float pdf(const Vec3& d) const;

   private:
    float height_of(const Vec3& d) const;  ///< 1 - cos of the angle from the axis
    Frame frame_;
    float height_ = 2;
  };

  std::unique_ptr<Scene> scene_;
  const Emitter* emitter_ = nullptr;
  bool is_surface_ = false;
  std::optional<EmissionCone> cone_;  ///< for reference_emission()
};

/// Returns sample_emission() for random numbers.
std::optional<EmissionSample> random_emission(const Emitter& emitter, Random& random);

/// Returns a / b, or infinity instead of NaN, so that ratios can be sorted.
float ratio_of(float a, float b);
/// Makes the check fail if the median of the ratios isn't 1 to within 0.002. There must be at least
/// one; reorders them. `what` is a format for the median, which is returned.
float check_ratios(std::vector<float>& ratios, const std::string& what, Outcome& outcome);

/// Describes how samples differ from a density.
std::string cause_of(const DensityVerdict& verdict, const std::string& pdf_name);

}  // namespace kinome::check
