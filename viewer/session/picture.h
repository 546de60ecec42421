#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kinome/image.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"

namespace kinome::viewer {

/// A picture that a RenderSession has rendered, finished or on the way. Never changed once it is
/// published: it may be read by all threads for as long as they hold it.
struct Picture {
  Image image;              ///< with all of its channels; of a preview, of fewer pixels
  RenderStats stats;        ///< of the render so far: rays, samples that were not finite, ...
  uint64_t generation = 0;  ///< counts the session's pictures from 1
  uint64_t edition = 0;     ///< counts the changes of the scene that it shows
  /// What it stands for, in pixels of the sensor's film: its crop window.
  Rect crop;
  bool is_preview = false;  ///< of fewer pixels, or by another integrator, than was asked for
  bool is_final = false;    ///< all samples that were asked for are in it
  std::string integrator;   ///< the plugin's name
  double samples = 0;       ///< a pixel
  double seconds = 0;       ///< of rendering, without pauses
  /// As estimated from what several renders of the picture differ by (estimate_rel_mse); negative:
  /// there is no telling.
  double rel_mse = -1;
  double rays_per_second = 0;
  /// What it is seen by; nullptr: a sensor that is part of a shape, which may change meanwhile.
  std::shared_ptr<const Sensor> sensor;
};
using PicturePointer = std::shared_ptr<const Picture>;

/// From the camera, through a place of the film [pixels] and the middle of the lens; nullopt: there
/// is no telling.
std::optional<Ray> ray_through(const Picture& picture, const Vec2& film_position);
/// Where a point is seen on the film, whatever hides it; nullopt: it isn't.
std::optional<Vec2> place_on_film(const Picture& picture, const Vec3& point);

/// Writes a picture by the ending of its name: .exr (all channels, as numbers of single precision)
/// or .png (sRGB). Throws Error.
void write_picture(const std::string& path, const Picture& picture);

}  // namespace kinome::viewer
