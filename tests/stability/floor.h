#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kinome/bsdf.h"
#include "kinome/image.h"
#include "support/statistics.h"

/// A bare square in the plane z = 0 that faces +z, and what a camera with parallel rays sees of it:
/// nothing hides any light, so that each pixel is an integral that can be taken by quadrature, in
/// double precision, without any code that samples. What lights it is written down anew here.
namespace kinome::test {

/// Radiance that the BSDF makes of light: f cos, towards the camera, of the unit direction d.
using Reflect = std::function<glm::dvec3(const glm::dvec3& d)>;
/// The reflected radiance at p. `fineness` (1, 2) of whatever is integrated.
using FloorLight =
    std::function<glm::dvec3(const glm::dvec3& p, const Reflect& reflect, int fineness)>;

struct Floor {
  glm::dvec3 toward_camera{0.5, 0.3, 0.8};  ///< not normalised
  double half_width = 0.5;                  ///< of the picture, in the camera's plane
  int side = 12;                            ///< pixels, each way
  /// True where all of the floor looks alike: light from infinitely far.
  bool is_even = true;
  /// Of everything but the pixels: the world is turned, scaled and moved by this.
  std::string operations;
  double scale = 1;  ///< of lengths, by `operations`

  std::string sensor_xml(const std::string& sampler = "independent") const;
  std::string shape_xml(const std::string& bsdf) const;
  /// R, G, B of all pixels, and how far they may be off.
  std::vector<Estimate> expected(const std::string& bsdf, const FloorLight& light) const;
};

/// An environment map in memory: row 0 around `up`, texels interpolated bilinearly between their
/// centres along phi, and between rows that reach from pole to pole along theta.
struct MapLight {
  int width, height;
  std::vector<glm::dvec3> texels;
  /// Columns: the map's axes in the world.
  glm::dmat3 to_world{1.0};

  static MapLight of(int width, int height, const std::function<Rgb(int x, int y)>& texel,
                     const glm::dmat3& to_world = glm::dmat3(1.0));
  Image image() const;
  glm::dvec3 radiance(double u, double v) const;
  FloorLight light() const;
};

/// Light of the same radiance from everywhere.
FloorLight even_light(const Rgb& radiance);
/// A point of this intensity, multiplied by `falloff` of the direction from the light.
FloorLight point_light(const glm::dvec3& position, const Rgb& intensity,
                       const std::function<double(const glm::dvec3& d)>& falloff = nullptr);
/// Parallel light that goes along `direction`.
FloorLight parallel_light(const glm::dvec3& direction, const Rgb& irradiance);
/// A parallelogram centre + s a + t b, s and t in [-1, 1], that shines on the side of `normal`.
FloorLight square_light(const glm::dvec3& centre, const glm::dvec3& a, const glm::dvec3& b,
                        const Rgb& radiance);
/// A sphere too small to have an extent that matters.
FloorLight small_sphere_light(const glm::dvec3& centre, double radius, const Rgb& radiance);
/// All of them together.
FloorLight sum_of(const std::vector<FloorLight>& lights);

}  // namespace kinome::test
