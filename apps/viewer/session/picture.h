#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kinome/image.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"

namespace kinome::viewer {

/// Returns true if two rectangles have the same pixels.
inline bool is_same(const Rect& a, const Rect& b) {
  return a.x0 == b.x0 && a.y0 == b.y0 && a.x1 == b.x1 && a.y1 == b.y1;
}

/// A finished or unfinished image of a RenderSession. It never changes once it is published, so any
/// thread that holds it can read it.
struct Picture {
  Image image;              ///< all channels; a preview may have fewer pixels
  RenderStats stats;        ///< of the render so far: rays, non-finite samples, ...
  uint64_t generation = 0;  ///< number of the image in the session, from 1
  uint64_t edition = 0;     ///< number of the scene's version that the image shows
  Rect crop;                ///< crop window of the sensor's film, in pixels
  bool is_preview = false;  ///< with fewer pixels or another integrator than requested
  bool is_part = false;     ///< has finished tiles of a pass that isn't counted in `samples` yet
  bool is_final = false;    ///< contains all requested samples
  std::string integrator;   ///< name of the plugin
  double samples = 0;       ///< per pixel
  double seconds = 0;       ///< rendering time without pauses
  /// Relative error, estimated from the differences of the film's lanes (estimate_rel_mse);
  /// negative if unknown.
  double rel_mse = -1;
  double rays_per_second = 0;
  /// Sensor of the image; nullptr if it is part of a shape, which may change in the meantime.
  std::shared_ptr<const Sensor> sensor;
};
using PicturePointer = std::shared_ptr<const Picture>;

/// Returns the camera ray through a position on the film [pixels] and the centre of the lens, or
/// nullopt if the image has no sensor.
std::optional<Ray> ray_through(const Picture& picture, const Vec2& film_position);
/// Projects a point onto the film, ignoring occlusion. Returns nullopt if the sensor doesn't see it
/// or the image has no sensor.
std::optional<Vec2> place_on_film(const Picture& picture, const Vec3& point);

/// Reads an image from a .exr or .pfm file. Throws Error.
Image read_picture(const std::string& path);
/// Writes an image as .exr (all channels, single precision) or .png (sRGB), by the file's
/// extension. Throws Error.
void write_picture(const std::string& path, const Picture& picture);

}  // namespace kinome::viewer
