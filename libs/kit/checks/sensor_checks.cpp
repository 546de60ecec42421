// Checks of sensors: their rays, their connections, and the agreement of the two.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kit/scenes/block_memory.h"
#include "kit/scenes/lit_scene.h"
#include "kit/scenes/receivers.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

std::unique_ptr<Scene> scene_of_sensor(const Subject& subject) {
  const auto sensor = subject.make<Sensor>();
  const std::string nested =
      sensor->is_surface() ? "<shape type='sphere'><point name='center' x='0' y='0' z='3'/>" +
                                 subject.xml() + "</shape>"
                           : subject.xml();
  return subject.scene_of("<integrator type='direct'/>" + std::string(kLitScene) + nested);
}

/// Returns a random position in the crop window of the film.
Vec2 position_on_film(const Sensor& sensor, Random& random) {
  const Rect& crop = sensor.film().crop();
  return Vec2(crop.x0, crop.y0) + random.unit2() * Vec2(crop.width(), crop.height());
}

/// Clamps a distance to the clip range of a ray.
float distance_on(const Ray& ray, float distance) {
  return std::max(1.5f * ray.tmin, std::min(0.5f * ray.tmax, distance));
}

Outcome sensor_rays(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Sensor& sensor = *scene->sensors().at(0);
  Random random(subject.request().seed + 1);
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  const Columns2 film = memory.two(), lens = memory.two();
  for (size_t i = 0; i < count; ++i) {
    film.set(i, position_on_film(sensor, random));
    lens.set(i, random.unit2());
  }
  std::vector<RayHit16> blocks(padded(count) / 16);
  for (RayHit16& block : blocks) reset(block.ray);
  sensor.sample_ray_block(film, lens, count, blocks.data());
  int different = 0, aperture = 0;
  for (size_t i = 0; i < count && outcome.passed; ++i) {
    const Ray ray = sensor.sample_ray(film.at(i), lens.at(i));
    const std::string where =
        fmt::format(", through ({:.5g}, {:.5g})", film.at(i).x, film.at(i).y);
    if (!is_finite(ray.o) || !is_finite(ray.d)) outcome.fail("a ray is not finite" + where);
    if (std::abs(glm::length(ray.d) - 1) > 1e-4f) {
      outcome.fail("a ray's direction is not of unit length" + where);
    }
    if (!(ray.tmin >= 0 && ray.tmax > ray.tmin)) {
      outcome.fail("the interval from tmin to tmax is empty" + where);
    }
    const Ray other = ray_of(&blocks[i / 16].ray, i % 16);
    const float size = 1 + glm::length(ray.o);
    different += !(glm::length(ray.o - other.o) <= 1e-4f * size &&
                   glm::length(ray.d - other.d) <= 1e-4f);
    const Ray central = sensor.sample_ray(film.at(i), Vec2(0.5f));
    aperture +=
        glm::length(ray.o - central.o) > 1e-5f * size || glm::length(ray.d - central.d) > 1e-5f;
  }
  outcome.fail_if_many(different, static_cast<int>(count), 200,
                       "sample_ray_block() differs from sample_ray() for {} of {} rays");
  if (aperture > 0 && !sensor.needs_aperture_sample()) {
    outcome.fail("rays depend on `aperture`, but needs_aperture_sample() is false");
  }
  outcome.measured = fmt::format("{} rays, blocks compared with single rays", count);
  return outcome;
}

/// Checks that connect() returns the film position of points on rays of the film.
Outcome sensor_connect(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Sensor& sensor = *scene->sensors().at(0);
  Random random(subject.request().seed + 2);
  const Rect& crop = sensor.film().crop();
  int seen = 0, lost = 0;
  const int count = subject.samples(2000);
  for (int i = 0; i < count; ++i) {
    const Vec2 film = position_on_film(sensor, random);
    const Vec2 aperture = random.unit2();
    const Ray ray = sensor.sample_ray(film, aperture);
    const auto found = sensor.connect(ray.at(distance_on(ray, random.between(1, 8))), aperture);
    lost += !found;
    if (!found) continue;
    ++seen;
    const float size = static_cast<float>(std::max(crop.width(), crop.height()));
    if (!(glm::length(found->film_position - film) <= 2e-3f * size)) {
      outcome.fail(
          fmt::format("connect() returns a wrong film position for a point of the ray "
                      "through ({:.5g}, {:.5g}): ({:.5g}, {:.5g})",
                      film.x, film.y, found->film_position.x, found->film_position.y));
    }
    if (!(glm::length(found->d + ray.d) < 2e-3f)) {
      outcome.fail("connect() returns a d that doesn't point back along the ray");
    }
    if (!(found->weight > 0 && std::isfinite(found->weight))) {
      outcome.fail(fmt::format("connect() returns the weight {}", found->weight));
    }
  }
  if (seen > 0) {
    outcome.fail_if_many(lost, count, 50,
                         "connect() returns nothing for {} of {} points of its rays");
  }
  outcome.measured =
      seen > 0 ? fmt::format("{} points of rays", seen) : "not implemented: ptracer renders black";
  return outcome;
}

Outcome sensor_connect_blocks(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Sensor& sensor = *scene->sensors().at(0);
  Random random(subject.request().seed + 3);
  const auto count = static_cast<size_t>(subject.samples(1001));
  BlockMemory memory(count);
  const Columns3 p = memory.three();
  const Columns2 lens = memory.two();
  for (size_t i = 0; i < count; ++i) {
    lens.set(i, random.unit2());
    const Ray ray = sensor.sample_ray(position_on_film(sensor, random), lens.at(i));
    p.set(i, ray.at(distance_on(ray, random.between(1, 8))));
  }
  const ConnectionBlock out{memory.two(), memory.three(), memory.one(), memory.one()};
  sensor.connect_block(p, lens, count, out);
  int different = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto found = sensor.connect(p.at(i), lens.at(i));
    if (!found || !(out.weight[i] > 0)) {
      different += found.has_value() != (out.weight[i] > 0);
      continue;
    }
    const float size = 1 + glm::length(p.at(i));
    different += !(glm::length(found->film_position - out.film_position.at(i)) < 0.01f &&
                   glm::length(found->d - out.d.at(i)) < 1e-4f &&
                   std::abs(found->distance - out.distance[i]) < 1e-4f * size &&
                   std::abs(found->weight - out.weight[i]) < 2e-3f * found->weight);
  }
  outcome.fail_if_many(different, static_cast<int>(count), 100,
                       "connect_block() differs from connect() at {} of {} points");
  if (memory.is_overrun()) outcome.fail("connect_block() writes beyond its columns");
  outcome.measured =
      fmt::format("blocks of {} points compared with single points, bound 1 of 100", count);
  return outcome;
}

/// Returns a rectangle perpendicular to the view that the rays of about half of the film cross. If
/// the rays' directions cancel, as for a panoramic camera, it is on the film's central ray. It is
/// not close to the camera, because the weights of connections to near points are unbounded.
Receiver screen_of(const Sensor& sensor, Random& random) {
  std::vector<Ray> rays;
  Vec3 sum(0.f), middle(0.f);
  constexpr int kRays = 2000;
  for (int i = 0; i < kRays; ++i) {
    const Vec2 position = position_on_film(sensor, random);
    rays.push_back(sensor.sample_ray(position, random.unit2()));
    sum += rays.back().d;
    middle += rays.back().at(distance_on(rays.back(), 4)) / static_cast<float>(kRays);
  }
  Vec3 axis = sum / static_cast<float>(kRays);
  if (glm::length(axis) > 0.1f) {
    axis = glm::normalize(axis);
  } else {
    const Rect& crop = sensor.film().crop();
    const Vec2 center = 0.5f * Vec2(crop.x0 + crop.x1, crop.y0 + crop.y1);
    const Ray central = sensor.sample_ray(center, Vec2(0.5f));
    axis = central.d;
    middle = central.at(distance_on(central, 4));
  }
  const Frame frame = Frame::from_normal(-axis);
  std::vector<float> extents;
  for (const Ray& ray : rays) {
    const Vec3 local = frame.to_local(ray.at(distance_on(ray, 4)) - middle);
    extents.push_back(std::max(std::abs(local.x), std::abs(local.y)));
  }
  const auto half = extents.begin() + kRays / 2;
  std::nth_element(extents.begin(), half, extents.end());
  return Receiver::plane(middle, frame, Vec2(std::max(*half, 1e-3f)));
}

/// Compares the sum of all pixels for a screen with radiance 1, by connect() as in light tracing,
/// and by rays of the film that hit the screen.
Outcome sensor_importance(const Subject& subject, double alpha) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Sensor& sensor = *scene->sensors().at(0);
  Random random(subject.request().seed + 4);
  const Receiver screen = screen_of(sensor, random);
  const Rect& crop = sensor.film().crop();
  const auto pixels = static_cast<float>(crop.area());
  const int count = subject.samples(40000);
  const auto add_ray = [&](const auto& add) {
    const Vec2 position = position_on_film(sensor, random);
    const Ray ray = sensor.sample_ray(position, random.unit2());
    screen.for_each_crossing(ray.at(ray.tmin), ray.d, add);
  };
  std::vector<ReceiverCells::Hit> hits;
  for (int i = 0; i < 10000; ++i) {
    add_ray([&](const Vec2& uv, bool is_front) { hits.push_back({uv, is_front}); });
  }
  const ReceiverCells cells(hits, static_cast<double>(hits.size()) * count / 10000);
  CellFlux by_rays(cells.count()), by_connections(cells.count());
  for (int i = 0; i < count; ++i) {
    add_ray([&](const Vec2& uv, bool is_front) {
      by_rays.add(cells.cell_of(uv, is_front), Rgb(pixels));
    });
    by_rays.end_sample();
    const Vec2 uv = random.unit2();
    const Receiver::Point point = screen.at(uv);
    const auto seen = sensor.connect(point.p, random.unit2());
    if (seen && seen->film_position.x >= static_cast<float>(crop.x0) &&
        seen->film_position.x < static_cast<float>(crop.x1) &&
        seen->film_position.y >= static_cast<float>(crop.y0) &&
        seen->film_position.y < static_cast<float>(crop.y1)) {
      const float cosine = glm::dot(point.n, seen->d);
      const auto intensity = static_cast<float>(screen.area()) * std::abs(cosine);
      by_connections.add(cells.cell_of(uv, cosine > 0), Rgb(intensity * seen->weight));
    }
    by_connections.end_sample();
  }
  if (by_connections.contributions() == 0) {
    outcome.measured = "not implemented: ptracer renders black";
    return outcome;
  }
  const Verdict verdict =
      largest_z_test(by_connections.estimates(), by_rays.estimates(), alpha);
  const double ratio = by_connections.total() / by_rays.total();
  outcome.measured = fmt::format(
      "a screen is {:.4g} times as bright by connect() as by rays, p "
      "{:.2g} for {} cells, bound {:.0e}",
      ratio, verdict.p_value, cells.count(), alpha);
  if (!verdict.passed) {
    outcome.fail(std::abs(ratio - 1) < 0.02
                     ? std::string("connect() returns wrong weights in parts of the view")
                     : fmt::format("connect() returns weights {:.2g} times those of rays", ratio));
  }
  return outcome;
}

Outcome sensor_picture(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Image image = render_image(*scene, 1, 1);
  for (const float value : image.data) {
    if (!std::isfinite(value)) outcome.fail("an image by `direct` has a value that is not finite");
  }
  outcome.measured = fmt::format("{} x {} pixels", image.width, image.height);
  return outcome;
}

}  // namespace

void add_sensor_checks(const Subject& subject, Plan& plan) {
  plan.add("rays", 0, [&](double) { return sensor_rays(subject); });
  plan.add("connect", 0, [&](double) { return sensor_connect(subject); });
  plan.add("connect_blocks", 0, [&](double) { return sensor_connect_blocks(subject); });
  plan.add("importance", 1, [&](double alpha) { return sensor_importance(subject, alpha); });
  plan.add("picture", 0, [&](double) { return sensor_picture(subject); });
}

}  // namespace kinome::check
