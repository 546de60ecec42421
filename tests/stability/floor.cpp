#include "floor.h"

#include <cmath>
#include <numbers>

#include "kinome/emitter.h"
#include "support/render.h"
#include "xml.h"

namespace kinome::test {
namespace {

constexpr double kPiD = std::numbers::pi;

std::string tilted_view(const Floor& floor) {
  const glm::dvec3 d = 4. * glm::normalize(floor.toward_camera);
  // Parallel rays: this scale is the width of the image.
  return xml::scale(
             Vec3(static_cast<float>(floor.half_width), static_cast<float>(floor.half_width), 1)) +
         xml::look_at(Vec3(d), Vec3(0.f), Vec3(0.1f, 1, 0));
}

}  // namespace

std::string Floor::sensor_xml(const std::string& sampler) const {
  return xml::sensor("orthographic", tilted_view(*this) + operations, side, side, 1, sampler,
                     xml::number("near_clip", 0.01 * scale) + xml::number("far_clip", 1e3 * scale));
}

std::string Floor::shape_xml(const std::string& bsdf) const {
  return xml::shape("rectangle", xml::to_world(operations) + bsdf);
}

std::vector<Estimate> Floor::expected(const std::string& bsdf_xml, const FloorLight& light) const {
  const auto bsdf = make<Bsdf>(bsdf_xml);
  SurfaceInteraction si;
  si.wi = Vec3(glm::normalize(toward_camera));
  const Reflect reflect = [&](const glm::dvec3& d) {
    return d.z > 0 ? glm::dvec3(bsdf->eval_pdf(si, Lobe::kAll, Vec3(d)).f) : glm::dvec3(0.);
  };
  // The camera without `operations` gives the positions of pixels on the floor.
  const auto sensor = make<Sensor>(xml::sensor("orthographic", tilted_view(*this), side, side, 1));
  const auto place = [&](double x, double y) {
    const Ray ray =
        sensor->sample_ray(Vec2(static_cast<float>(x), static_cast<float>(y)), Vec2(0.5f));
    const glm::dvec3 o(ray.o), d(ray.d);
    return o - d * (o.z / d.z);
  };
  const auto pixel = [&](int x, int y, int fineness) {
    const int steps = is_even ? 1 : 3 * fineness;
    glm::dvec3 sum(0.);
    for (int i = 0; i < steps * steps; ++i) {
      sum += light(place(x + (i % steps + 0.5) / steps, y + (i / steps + 0.5) / steps), reflect,
                   fineness);
    }
    return sum / static_cast<double>(steps * steps);
  };
  std::vector<Estimate> pixels;
  glm::dvec3 fine(0.), coarse(0.);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      if (!is_even || pixels.empty()) {
        fine = pixel(x, y, 2);
        coarse = pixel(x, y, 1);
      }
      // The error at half the step is a fraction of the difference between both.
      for (int c = 0; c < 3; ++c) {
        const double error = 0.5 * (fine[c] - coarse[c]);
        pixels.push_back({fine[c], error * error});
      }
    }
  }
  return pixels;
}

MapLight MapLight::of(int width, int height, const std::function<Rgb(int x, int y)>& texel,
                      const glm::dmat3& to_world) {
  MapLight map{width, height, {}, to_world};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) map.texels.emplace_back(texel(x, y));
  }
  return map;
}

Image MapLight::image() const {
  Image image{width, height, {"R", "G", "B"}, {}};
  for (const glm::dvec3& t : texels) {
    for (int c = 0; c < 3; ++c) image.data.push_back(static_cast<float>(t[c]));
  }
  return image;
}

glm::dvec3 MapLight::radiance(double u, double v) const {
  const double x = u * width - 0.5, y = v * (height - 1);
  const double column = std::floor(x), row = std::min(std::floor(y), std::max(0., height - 2.));
  const double s = x - column, t = height == 1 ? 0 : y - row;
  const auto texel = [&](double cx, double cy) {
    const int wrapped = (static_cast<int>(cx) % width + width) % width;
    return texels[static_cast<size_t>(std::min(static_cast<int>(cy), height - 1)) * width +
                  wrapped];
  };
  return (texel(column, row) * (1 - s) + texel(column + 1, row) * s) * (1 - t) +
         (texel(column, row + 1) * (1 - s) + texel(column + 1, row + 1) * s) * t;
}

FloorLight MapLight::light() const {
  // Between texels, radiance is a product of linear functions: two Gauss points per axis and part
  // are exact. The parts are needed for the BSDF.
  return [map = *this](const glm::dvec3&, const Reflect& reflect, int fineness) {
    constexpr double kNodes[] = {0.21132486540518713, 0.78867513459481287};
    const int gaps = std::max(1, map.height - 1);
    const int parts_u = fineness * ((127 + map.width) / map.width);
    const int parts_v = fineness * ((63 + gaps) / gaps);
    const double du = 1. / (map.width * parts_u), dv = 1. / (gaps * parts_v);
    glm::dvec3 sum(0.);
    for (int row = 0; row < gaps * parts_v; ++row) {
      for (int column = 0; column < map.width * parts_u; ++column) {
        for (const double t : kNodes) {
          for (const double s : kNodes) {
            const double u = 0.5 / map.width + (column + s) * du, v = (row + t) * dv;
            const glm::dvec3 light = map.radiance(u, v);
            if (light == glm::dvec3(0.)) continue;
            const double phi = 2 * kPiD * u, theta = kPiD * v;
            const glm::dvec3 d(std::sin(phi) * std::sin(theta), std::cos(theta),
                               -std::cos(phi) * std::sin(theta));
            sum += light * reflect(map.to_world * d) * std::sin(theta);
          }
        }
      }
    }
    return sum * 0.25 * (2 * kPiD * du) * (kPiD * dv);
  };
}

FloorLight even_light(const Rgb& radiance) {
  return [light = glm::dvec3(radiance)](const glm::dvec3&, const Reflect& reflect, int fineness) {
    const int steps = 150 * fineness;
    glm::dvec3 sum(0.);
    for (int i = 0; i < steps; ++i) {
      const double theta = 0.5 * kPiD * (i + 0.5) / steps;
      for (int j = 0; j < 2 * steps; ++j) {
        const double phi = kPiD * (j + 0.5) / steps;
        sum += std::sin(theta) * reflect({std::sin(theta) * std::cos(phi),
                                          std::sin(theta) * std::sin(phi), std::cos(theta)});
      }
    }
    return light * sum * (0.5 * kPiD / steps) * (kPiD / steps);
  };
}

FloorLight point_light(const glm::dvec3& position, const Rgb& intensity,
                       const std::function<double(const glm::dvec3& d)>& falloff) {
  return [=](const glm::dvec3& p, const Reflect& reflect, int) {
    const glm::dvec3 to = position - p;
    const glm::dvec3 d = glm::normalize(to);
    return reflect(d) * glm::dvec3(intensity) * (falloff ? falloff(-d) : 1) / glm::dot(to, to);
  };
}

FloorLight parallel_light(const glm::dvec3& direction, const Rgb& irradiance) {
  return [d = -glm::normalize(direction), light = glm::dvec3(irradiance)](
             const glm::dvec3&, const Reflect& reflect, int) { return reflect(d) * light; };
}

FloorLight square_light(const glm::dvec3& centre, const glm::dvec3& a, const glm::dvec3& b,
                        const Rgb& radiance) {
  return [=](const glm::dvec3& p, const Reflect& reflect, int fineness) {
    const int steps = 12 * fineness;
    const glm::dvec3 normal = glm::cross(a, b);  // its length is a quarter of the area
    glm::dvec3 sum(0.);
    for (int i = 0; i < steps * steps; ++i) {
      const double s = 2 * (i % steps + 0.5) / steps - 1, t = 2 * (i / steps + 0.5) / steps - 1;
      const glm::dvec3 to = centre + s * a + t * b - p;
      const double distance2 = glm::dot(to, to);
      const glm::dvec3 d = to / std::sqrt(distance2);
      sum += reflect(d) * (std::max(0., -glm::dot(normal, d)) / distance2);
    }
    return glm::dvec3(radiance) * sum * 4. / static_cast<double>(steps * steps);
  };
}

FloorLight small_sphere_light(const glm::dvec3& centre, double radius, const Rgb& radiance) {
  return [=](const glm::dvec3& p, const Reflect& reflect, int) {
    const glm::dvec3 to = centre - p;
    return reflect(glm::normalize(to)) * glm::dvec3(radiance) *
           (kPiD * radius * radius / glm::dot(to, to));
  };
}

FloorLight sum_of(const std::vector<FloorLight>& lights) {
  return [=](const glm::dvec3& p, const Reflect& reflect, int fineness) {
    glm::dvec3 sum(0.);
    for (const FloorLight& light : lights) sum += light(p, reflect, fineness);
    return sum;
  };
}

}  // namespace kinome::test
