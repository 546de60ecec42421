#pragma once

#include <optional>
#include <vector>

#include "drawing/canvas.h"
#include "kinome/inspection.h"
#include "kinome/scene.h"

namespace kinome::drawing {

/// Where a pixel's light comes from, and how bright that is drawn: what an inspection's clusters
/// and samples are drawn over. Takes a fraction of a second to make.
struct InspectionView {
  Canvas canvas;
  std::vector<Vec3> place;     ///< direction or position of each pixel's centre
  std::vector<uint8_t> valid;  ///< where there is any
  Vec2 scale{1.f};             ///< of the scene: pixels of the picture for each of the film
  float slack = 0;             ///< by which light points may lie off the surface that is shown

  /// Where a position in the scene is drawn; nullopt where the camera doesn't see it.
  std::optional<Vec2> find(const Sensor& sensor, const Vec3& position) const;
};

/// Where Integrator::inspect() tells of no light at all: why.
inline constexpr const char* kNoLightPoints =
    "no emitter offers light points: environments do, and lamps by their bounce, with a max_depth of "
    "3 or more";

/// Size of a map of all directions by longitude (to the right) and latitude, +Y up; -Z is at the
/// left and the right edge.
inline constexpr int kMapWidth = 1024;
inline constexpr int kMapHeight = 512;
Vec3 map_direction(float x, float y);
Vec2 map_position(const Vec3& d);

/// For distant light. The environment as such a map: compressed, so that the sky shows beside a
/// sun.
InspectionView environment_view(const Scene& scene);
/// For local light. The scene as a lamp at the camera would show it; the film's picture, enlarged
/// where its longer side is less than 768 pixels.
InspectionView scene_view(const Scene& scene, const Sensor& sensor);

/// Outlines the clusters' boxes and draws the samples by weight, visible ones in red and shadowed
/// ones in blue. What has been learned to be hidden turns dark blue.
void draw_inspection(const Inspection& report, const Sensor& sensor, InspectionView& view);
/// Says below the picture what is seen there.
void add_legend(const Inspection& report, const Vec2& pixel, Canvas& canvas);

}  // namespace kinome::drawing
