#pragma once

#include <memory>

#include "clustered/media/media_trial.h"
#include "clustered/media/sources/fog_sources.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "transport/media/bodies/media_table.h"
#include "transport/path_parameters.h"
#include "transport/surfaces/scene_table.h"

namespace kinome {

/// Name of path tracing in reports of the method.
inline constexpr const char* kVolpath = "volpath";

/// Renders a scene with uniform media by FogBlock, or by path tracing if that is expected to take
/// less work. Passes share the tables, and the choice of the method.
class MediaRender {
 public:
  /// Returns why FogBlock can't render the scene, or nullptr if it can.
  static const char* why_paths(const Scene& scene, const Sensor& sensor,
                               const PathSettings& settings);

  /// With `has_trial`, a trial chooses between both methods. The scene, the sensor, which has the
  /// samples of the whole render, and the context must outlive the object.
  MediaRender(const Scene& scene, const Sensor& sensor, const PathSettings& settings,
              bool has_trial, RenderContext& context);

  /// Chooses the method for a pass of the sensor's samples. A trial is repeated only for a pass
  /// whose trial is twice as large. The choice is the same for any number of threads.
  void choose(const Sensor& sensor);
  const MediaChoice& choice() const { return choice_; }
  /// Sunlight is divided and its beams are learned when a choice first needs them.
  const FogSources& sources() const { return *sources_; }
  /// Renders the image of a sensor by the chosen method.
  void render(const Sensor& sensor) const;

 private:
  void find_sunlight();

  const Sensor& sensor_;
  const PathSettings settings_;
  const bool has_trial_;
  RenderContext& context_;
  const transport::MediaTable media_;
  const transport::SceneTable table_;
  std::unique_ptr<FogSources> sources_;
  bool has_sunlight_ = false;  ///< after find_sunlight()
  MediaChoice choice_;
  size_t tried_ = 0;  ///< number of blocks of the last trial
};

/// Progressive render by MediaRender. The pass in which the method changes has at most a quarter of
/// the requested samples, and at most as many as all passes before it, because its time can't be
/// predicted from theirs.
std::unique_ptr<Passes> media_passes(const Scene& scene, const Sensor& sensor,
                                     const PathSettings& settings, bool has_trial,
                                     RenderContext& context);

}  // namespace kinome
