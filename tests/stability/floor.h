#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kinome/bsdf.h"
#include "kinome/image.h"
#include "support/statistics.h"

/// A bare square in the plane z = 0 that faces +z, seen by a camera with parallel rays. Nothing is
/// occluded, so that each pixel is an integral that quadrature in double precision computes without
/// any sampling code. Its emitters are implemented independently here.
namespace kinome::test {

/// Reflected radiance per radiance from the unit direction d: f cos, toward the camera.
using Reflect = std::function<glm::dvec3(const glm::dvec3& d)>;
/// Returns the reflected radiance at p. `fineness` (1, 2) of the quadrature.
using FloorLight =
    std::function<glm::dvec3(const glm::dvec3& p, const Reflect& reflect, int fineness)>;

struct Floor {
  glm::dvec3 toward_camera{0.5, 0.3, 0.8};  ///< not normalised
  double half_width = 0.5;                  ///< half of the image's width, in the camera's plane
  int side = 12;                            ///< pixels per side
  /// True if the whole floor has the same radiance: light from infinitely far.
  bool is_even = true;
  /// Operations on everything except the pixels: they rotate, scale and translate the world.
  std::string operations;
  double scale = 1;  ///< scale of lengths in `operations`

  std::string sensor_xml(const std::string& sampler = "independent") const;
  std::string shape_xml(const std::string& bsdf) const;
  /// Returns R, G, B of all pixels, with their errors.
  std::vector<Estimate> expected(const std::string& bsdf, const FloorLight& light) const;
};

/// An environment map in memory, with row 0 around `up`. Texels are interpolated bilinearly: along
/// phi between their centres, along theta between rows that reach from pole to pole.
struct MapLight {
  int width, height;
  std::vector<glm::dvec3> texels;
  /// The columns are the map's axes in the world.
  glm::dmat3 to_world{1.0};

  static MapLight of(int width, int height, const std::function<Rgb(int x, int y)>& texel,
                     const glm::dmat3& to_world = glm::dmat3(1.0));
  Image image() const;
  glm::dvec3 radiance(double u, double v) const;
  FloorLight light() const;
};

/// Light of constant radiance from all directions.
FloorLight even_light(const Rgb& radiance);
/// A point light with this intensity, multiplied by `falloff` of the direction from the light.
FloorLight point_light(const glm::dvec3& position, const Rgb& intensity,
                       const std::function<double(const glm::dvec3& d)>& falloff = nullptr);
/// Parallel light that travels along `direction`.
FloorLight parallel_light(const glm::dvec3& direction, const Rgb& irradiance);
/// A parallelogram centre + s a + t b, with s and t in [-1, 1], that emits on the side of `normal`.
FloorLight square_light(const glm::dvec3& centre, const glm::dvec3& a, const glm::dvec3& b,
                        const Rgb& radiance);
/// A sphere so small that its size has no effect.
FloorLight small_sphere_light(const glm::dvec3& centre, double radius, const Rgb& radiance);
/// The sum of all lights.
FloorLight sum_of(const std::vector<FloorLight>& lights);

}  // namespace kinome::test
