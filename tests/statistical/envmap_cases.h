#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "kinome/image_files.h"
#include "kinome/emitter.h"
#include "kinome/image.h"
#include "support/render.h"

/// Environment maps for tests, and integrals over them.
namespace kinome::test {

inline constexpr double kPiD = 3.14159265358979323846;

using Texel = std::function<Rgb(int x, int y)>;

struct Map {
  const char* name;
  int width;
  int height;
  Texel texel;
};

inline Rgb noise(int x, int y) {
  const auto unit = [&](int c) { return static_cast<float>((x * 7 + y * 13 + c * 5) % 11); };
  return 0.125f * Rgb(1 + unit(0), 1 + unit(1), 1 + unit(2));
}

/// Difficult maps for samplers: suns at singular coordinates, negative values, degenerate sizes.
inline std::vector<Map> maps() {
  const auto sun_at = [](int sun_x, int sun_y, float sky) {
    return [=](int x, int y) { return x == sun_x && y == sun_y ? Rgb(2000, 1500, 900) : Rgb(sky); };
  };
  return {
      {"noise", 16, 9, noise},
      {"sun at the upper pole", 16, 9, sun_at(5, 0, 0.1f)},
      {"sun at the lower pole", 16, 9, sun_at(0, 8, 0.1f)},
      {"lone sun at the pole", 8, 33, sun_at(3, 0, 0)},
      {"lone sun beside the pole", 8, 33, sun_at(3, 1, 0)},
      {"sun on the seam, left", 16, 9, sun_at(0, 3, 0.1f)},
      {"sun on the seam, right", 16, 9, sun_at(15, 3, 0.1f)},
      {"negative texels", 16, 9,
       [](int x, int y) { return noise(x, y) - ((x + y) % 5 == 0 ? Rgb(1.5f) : Rgb(0.f)); }},
      {"all negative", 4, 4, [](int x, int y) { return -noise(x, y); }},
      {"1 x 1", 1, 1, noise},
      {"2 x 2", 2, 2, noise},
      {"1 x 7", 1, 7, noise},
      {"7 x 1", 7, 1, noise},
      {"3 x 2, half black", 3, 2, [](int x, int y) { return Rgb(x == 1 && y == 1 ? 1.f : 0.f); }},
      {"huge range", 8, 5, [](int x, int y) { return Rgb((x + y) % 3 ? 1e-20f : 1e12f); }},
  };
}

inline Image image_of(int width, int height, const Texel& texel) {
  Image image{width, height, {"R", "G", "B"}, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb c = texel(x, y);
      image.data.insert(image.data.end(), {c.x, c.y, c.z});
    }
  }
  return image;
}

inline std::shared_ptr<Emitter> envmap(const std::string& path, const std::string& more = "") {
  return make<Emitter>("<emitter type=\"envmap\"><string name=\"filename\" value=\"" + path +
                       "\"/>" + more + "</emitter>");
}

inline std::shared_ptr<Emitter> envmap(const Map& map, const std::string& more = "") {
  const TemporaryFolder folder;
  const std::string path = folder.path("map.pfm");
  write_pfm(path, image_of(map.width, map.height, map.texel));
  return envmap(path, more);
}

inline const std::string kRotation =
    "<transform name=\"to_world\"><rotate y=\"1\" angle=\"30\"/>"
    "<rotate x=\"1\" angle=\"-50\"/></transform>";

/// Applies kRotation in doubles.
inline glm::dvec3 rotated(const glm::dvec3& d) {
  const double a = 30 * kPiD / 180, b = -50 * kPiD / 180;
  const glm::dvec3 y(std::cos(a) * d.x + std::sin(a) * d.z, d.y,
                     -std::sin(a) * d.x + std::cos(a) * d.z);
  return {y.x, std::cos(b) * y.y - std::sin(b) * y.z, std::sin(b) * y.y + std::cos(b) * y.z};
}
inline glm::dvec3 unrotated(const glm::dvec3& d) {
  // The inverse is the transpose: its rows are the images of the axes.
  return {glm::dot(rotated({1, 0, 0}), d), glm::dot(rotated({0, 1, 0}), d),
          glm::dot(rotated({0, 0, 1}), d)};
}

inline glm::dvec3 direction(double u, double v) {
  const double phi = 2 * kPiD * u, theta = kPiD * v;
  return {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)};
}

struct Coordinates {
  double u;
  double v;
};
inline Coordinates coordinates(const glm::dvec3& d) {
  double u = std::atan2(d.x, -d.z) / (2 * kPiD);
  if (u < 0) u += 1;
  return {u, std::atan2(std::hypot(d.x, d.z), d.y) / kPiD};
}

/// A grid over (u, v) that includes the lines at which a map's interpolation has kinks. Within a
/// cell, pdf x sin theta is linear in u and quadratic in v. Two Gauss points per axis integrate it
/// exactly.
struct Grid {
  int columns;
  int rows;
  double shift;  ///< offset of the first line: half a texel

  Grid(int width, int height, int parts)
      : columns(width * parts), rows(std::max(1, height - 1) * parts), shift(0.5 / width) {
    // Maps with few rows are refined by an integer factor, to at least 32 intervals.
    if (height - 1 < 32) rows *= (31 + std::max(1, height - 1)) / std::max(1, height - 1);
  }

  template <class Function>
  double integrate(int column, int row, const Function& f) const {
    constexpr double kNodes[] = {0.21132486540518713, 0.78867513459481287};
    double sum = 0;
    for (const double s : kNodes) {
      for (const double t : kNodes) {
        const double v = (row + t) / rows;
        sum += f(direction(shift + (column + s) / columns, v)) * std::sin(kPiD * v);
      }
    }
    return sum * 0.25 * 2 * kPiD * kPiD / (static_cast<double>(columns) * rows);
  }
  template <class Function>
  double integrate(const Function& f) const {
    double sum = 0;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) sum += integrate(x, y, f);
    }
    return sum;
  }
  size_t cell(const Coordinates& at) const {
    double u = at.u - shift;
    u -= std::floor(u);
    const int x = std::min(static_cast<int>(u * columns), columns - 1);
    const int y = std::min(static_cast<int>(at.v * rows), rows - 1);
    return static_cast<size_t>(y) * columns + x;
  }
};

inline Vec2 random_pair(std::mt19937& rng) {
  const auto x = static_cast<float>(rng() >> 8), y = static_cast<float>(rng() >> 8);
  return Vec2(x, y) * 0x1p-24f;
}

}  // namespace kinome::test
