#pragma once

#include <optional>
#include <vector>

#include "drawing/canvas.h"
#include "kinome/inspection.h"
#include "kinome/scene.h"

namespace kinome::drawing {

/// Background of an inspection: the environment or the scene, over which clusters and samples are
/// drawn. Takes a fraction of a second to create.
struct InspectionView {
  Canvas canvas;
  std::vector<Vec3> positions;  ///< direction or position at the centre of each pixel
  std::vector<uint8_t> valid;   ///< for each pixel, whether there is one
  Vec2 scale{1.f};              ///< pixels of the image per pixel of the film
  float slack = 0;              ///< maximum distance of light points from the visible surface

  /// Returns the pixel at which a position in the scene is drawn; nullopt if the camera doesn't see
  /// it.
  std::optional<Vec2> find(const Sensor& sensor, const Vec3& position) const;
};

/// Error message if Integrator::inspect() returns nothing.
inline constexpr const char* kNoLightPoints =
    "the scene has no light points: they represent environments, and with a max_depth of 3 or more "
    "also the bounced light of other emitters";

/// Size of a map of all directions. Longitude increases to the right, +Y is up, and -Z is at the
/// left and right edges.
inline constexpr int kMapWidth = 1024;
inline constexpr int kMapHeight = 512;
Vec2 map_position(const Vec3& d);

/// Draws a report over a view of its kind of light. For distant light, this is such a map of the
/// environment; the radiance L is tone-mapped to L / (1 + L), so that the sky is visible beside the
/// sun. For local light, it is the scene, lit from the camera, and enlarged if the film's longer
/// side is less than 768 pixels.
///
/// Outlines the clusters' boxes and draws the samples by weight, visible ones in red and shadowed
/// ones in blue. Clusters with a low learned visibility become dark blue.
InspectionView inspection_view(const Inspection& report, const Scene& scene, const Sensor& sensor);
/// Adds a legend below the image.
void add_legend(const Inspection& report, const Vec2& pixel, Canvas& canvas);

}  // namespace kinome::drawing
