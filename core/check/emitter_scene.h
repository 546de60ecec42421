#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "check/density_cells.h"
#include "check/subject.h"
#include "kinome/emitter.h"

namespace kinome::check {

/// The emitter that is checked, in a scene, and what it tells of its light by other functions than
/// those that sample it.
class EmitterScene {
 public:
  /// `index`: which of the emitters of this plugin that the scene has.
  explicit EmitterScene(const Subject& subject, int index = 0);
  /// The emitter of this element, in place of the one that is checked.
  EmitterScene(const Subject& subject, const std::string& xml, int index);
  /// Number of emitters in the scene: surfaces are checked on shapes of two kinds.
  static int count(const Subject& subject);

  const Scene& scene() const { return *scene_; }
  const Emitter& emitter() const { return *emitter_; }
  /// A place that light may come to.
  Vec3 place(Random& random) const;

  /// Density of a direction from p; of surfaces that of all their points that lie in it.
  double pdf_along(const Vec3& p, const Vec3& d) const;
  /// The same at the very point that was sampled, where that is found again.
  std::optional<float> pdf_of(const Vec3& p, const DirectSample& sample) const;
  bool is_surface() const { return is_surface_; }
  const char* pdf_name() const { return is_surface_ ? "pdf_surface()" : "pdf_environment()"; }
  const char* value_name() const;

  /// A direction of light, and what of its power it stands for in the mean, as EmissionSample has
  /// it times pdf_position of light from infinitely far; `o` is where other light starts.
  std::pair<Vec3, Rgb> reference_emission(Random& random, const Vec3& o);

 private:
  /// A cone around all directions that light leaves in, and a uniform density within it.
  class Beam {
   public:
    explicit Beam(const Emitter& emitter);
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
  std::optional<Beam> beam_;  ///< for reference_emission()
};

/// a / b, or infinity where that is no number, so that ratios have an order.
float ratio_of(float a, float b);
/// The middle of some numbers, at least one.
float middle_of(std::vector<float>& values);

/// What is wrong where samples don't follow a density.
std::string cause_of(const DensityVerdict& verdict, const std::string& pdf_name);

}  // namespace kinome::check
