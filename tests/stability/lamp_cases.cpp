// Local light: emitters of extreme size, number and power over a bare floor, against quadrature.
// Light after one bounce, by virtual point lights, in rooms.
#include <cmath>
#include <numbers>

#include "matrix.h"
#include "xml.h"

namespace kinome::test {
namespace {

constexpr double kPiD = std::numbers::pi;

Floor near_floor() {
  Floor floor;
  floor.is_even = false;
  return floor;
}

Trial over_the_floor(const std::string& name, const std::string& lamps, const FloorLight& light) {
  Trial t;
  t.name = name;
  t.has_lamps = true;
  t.scene = [=](const std::string& bsdf) {
    return near_floor().sensor_xml() + near_floor().shape_xml(bsdf) + lamps;
  };
  t.expectation.kind = Expectation::Kind::kIntegral;
  t.expectation.integral = [=](const std::string& bsdf) {
    return near_floor().expected(bsdf, light);
  };
  return t;
}

Trial refused(const std::string& name, const std::string& lamps, std::vector<std::string> words) {
  Trial t = over_the_floor(name, lamps, nullptr);
  t.expectation.kind = Expectation::Kind::kError;
  t.expectation.error = std::move(words);
  t.materials.resize(1);
  return t;
}

std::string point_xml(const Vec3& position, const Rgb& intensity) {
  return xml::emitter("point",
                      xml::point("position", position) + xml::color("intensity", intensity));
}
std::string sphere_xml(const Vec3& centre, double radius, const Rgb& radiance) {
  return xml::shape("sphere", xml::point("center", centre) + xml::number("radius", radius) +
                                  xml::emitter("area", xml::color("radiance", radiance)));
}

Case tiny_lamps() {
  Case c{15,
         "A density whose square overflows in the power heuristic",
         "Weights are computed from the ratio of two densities.",
         "render/direct/area_light_test.cpp statistical/bsdf_extremes_test.cpp",
         {}};
  // The densities per solid angle are 3e7, 3e13 and 3e19; the square of the last overflows.
  for (const double radius : {1e-4, 1e-7, 1e-10}) {
    const glm::dvec3 centre(.3, -.2, .9);
    const Rgb radiance = Rgb(3, 2, 1) * static_cast<float>(1 / (kPiD * radius * radius));
    c.trials.push_back(over_the_floor("sphere of radius " + xml::digits(radius),
                                      sphere_xml(Vec3(centre), radius, radiance),
                                      small_sphere_light(centre, radius, radiance)));
  }
  const double half = 1e-9;
  const Rgb radiance(1e18f, 2e18f, 3e17f);
  c.trials.push_back(over_the_floor(
      "square of side 2e-9",
      xml::shape("rectangle", xml::to_world(xml::scale(half) + xml::rotate({1, 0, 0}, 180) +
                                            xml::translate({0, 0, 1})) +
                                  xml::emitter("area", xml::color("radiance", radiance))),
      square_light({0, 0, 1}, {half, 0, 0}, {0, -half, 0}, radiance)));
  return c;
}

/// Shines down from (.2, .1, 1).
std::string spot_xml(double cutoff, double beam, const Rgb& intensity) {
  return xml::emitter("spot", xml::to_world(xml::look_at({.2f, .1f, 1}, {.2f, .1f, 0}, {0, 1, 0})) +
                                  xml::color("intensity", intensity) +
                                  xml::number("cutoff_angle", cutoff) +
                                  xml::number("beam_width", beam));
}
FloorLight spot_light(double cutoff, double beam, const Rgb& intensity) {
  return point_light({.2, .1, 1}, intensity, [=](const glm::dvec3& d) {
    const double theta = std::acos(std::clamp(-d.z, -1., 1.)) * 180 / kPiD;
    return theta <= beam ? 1 : theta >= cutoff ? 0 : (cutoff - theta) / (cutoff - beam);
  });
}

Case parameters() {
  Case c{20,
         "Lights whose parameters give an infinite scale; spots of 0 and 90 degrees",
         "Values up to the limits are accepted, others refused; hard edges are supported.",
         "plugins/emitters/emitter_parameters_test.cpp render/direct/local_light_test.cpp",
         {}};
  const Rgb one(1, 2, 3);
  const auto spot = [&](const std::string& name, double cutoff, double beam, const Rgb& intensity) {
    c.trials.push_back(over_the_floor(name, spot_xml(cutoff, beam, intensity),
                                      spot_light(cutoff, beam, intensity)));
  };
  spot("spot, beam as wide as the cone (90)", 90, 90, one);
  spot("spot, 180 degrees", 180, 100, one);
  spot("spot, 85 degrees without a beam", 85, 0, one);
  spot("spot of 1e30", 80, 60, one * 1e30f);
  spot("spot of 1e-30", 80, 60, one * 1e-30f);
  c.trials.push_back(refused("spot of 0 degrees", spot_xml(0, 0, one), {"cutoff_angle", "got 0"}));
  c.trials.push_back(refused("spot of 1e37", spot_xml(40, 10, one * 1e37f), {"intensity", "1e36"}));
  c.trials.push_back(refused("beam wider than the cone", spot_xml(30, 40, one), {"beam_width"}));
  c.trials.push_back(refused(
      "spot of no size", xml::emitter("spot", xml::to_world("<scale value='0'/>")), {"singular"}));
  c.trials.push_back(refused("parallel light without a direction",
                             xml::emitter("directional", xml::vector("direction", Vec3(0.f))),
                             {"direction"}));
  c.trials.push_back(over_the_floor(
      "parallel light, a direction of 1e-30",
      xml::emitter("directional", xml::vector("direction", Vec3(1e-30f, 0, -2e-30f)) +
                                      xml::color("irradiance", one)),
      parallel_light({1, 0, -2}, one)));
  return c;
}

/// A room without a front wall, or a closed one.
std::string wall(const std::string& operations, const std::string& bsdf) {
  return xml::shape("rectangle", xml::to_world(operations) + bsdf);
}
std::string corner(const std::string& bsdf) {
  return wall("", bsdf) + wall(xml::rotate({0, 1, 0}, 90) + xml::translate({-1, 0, 1}), bsdf) +
         wall(xml::rotate({1, 0, 0}, 90) + xml::translate({0, 1, 1}), bsdf);
}

Trial bounce(const std::string& name, const Vec3& eye, const Vec3& target, double fov,
             const std::function<std::string(const std::string& bsdf)>& shapes,
             const std::string& lamps) {
  Trial t;
  t.name = name;
  t.has_lamps = true;
  t.max_depth = 3;
  t.renders = 32;
  t.scene = [=](const std::string& bsdf) {
    return xml::sensor("perspective", xml::look_at(eye, target, {0, 0, 1}), 12, 12, 1,
                       "independent", xml::number("fov", fov)) +
           shapes(bsdf) + lamps;
  };
  return t;
}

Case clusters() {
  Case c{8,
         "A cluster's angle underestimated: points inside, on and beside its box",
         "Cosines of a cluster are bounded by its box and its cone of normals; a cluster is "
         "skipped only if none of its points can light the position.",
         "plugins/integrators/kernels/local_cut_test.cpp plugins/integrators/kernels/light_cut_test.cpp statistical/local_clustered_test.cpp",
         {}};
  const std::string lamp = point_xml({-.2f, .1f, 1.2f}, {3, 4, 5});
  c.trials = {
      bounce("corner of three walls", {2.5f, -2.5f, 2.f}, {-.4f, .4f, .5f}, 45, corner, lamp),
      bounce("where two walls meet, from nearby", {-.9f, -.5f, .1f}, {-1, .9f, .02f}, 40, corner,
             lamp),
      bounce(
          "folded floor that lights itself", {0, -2.5f, 1.5f}, {0, 0, 0}, 40,
          [](const std::string& bsdf) {
            std::string folds;
            for (int i = -4; i < 4; ++i) {
              folds +=
                  wall(xml::scale(Vec3(.14f, 1, 1)) + xml::rotate({0, 1, 0}, i % 2 ? 30 : -30) +
                           xml::translate({.25f * static_cast<float>(i) + .1f, 0, 0}),
                       bsdf);
            }
            return folds;
          },
          point_xml({.1f, -.2f, 1}, {2, 2, 3})),
  };
  trial_named(c, "where two walls meet, from nearby").rarely_lit = {"path/roughconductor",
                                                                    "ptracer"};
  return c;
}

Case cones() {
  Case c{9,
         "NaN axes of cones from opposite or collinear normals; empty bounds",
         "A cluster without a mean normal is bounded only by its box.",
         "plugins/integrators/clustered/light_tree_test.cpp plugins/integrators/kernels/local_cut_test.cpp",
         {}};
  c.trials = {
      bounce(
          "two walls face to face", {0, -3, 1}, {0, 0, 1}, 35,
          [](const std::string& bsdf) {
            return wall(xml::rotate({0, 1, 0}, 90) + xml::translate({-.5f, 0, 1}), bsdf) +
                   wall(xml::rotate({0, 1, 0}, -90) + xml::translate({.5f, 0, 1}), bsdf);
          },
          point_xml({0, 0, 1}, {1, 2, 3})),
      bounce(
          "inside a sphere", {0, -.8f, 0}, {0, 1, .1f}, 60,
          [](const std::string& bsdf) {
            return xml::shape("sphere", xml::boolean("flip_normals", true) + bsdf);
          },
          point_xml({.1f, .2f, 0}, {1, 2, 3})),
      bounce(
          "both sides of one wall", {0, -3, 1}, {0, 0, .8f}, 40,
          [](const std::string& bsdf) {
            return wall(xml::rotate({0, 1, 0}, 90) + xml::translate({0, 0, 1}), bsdf) +
                   wall(xml::rotate({0, 1, 0}, -90) + xml::translate({0, 0, 1}), bsdf) +
                   wall("", bsdf);
          },
          point_xml({-.6f, 0, 1}, {1, 2, 3}) + point_xml({.6f, 0, 1}, {3, 2, 1})),
  };
  trial_named(c, "both sides of one wall").rarely_lit = {"path", "ptracer"};
  trial_named(c, "two walls face to face")
      .without.push_back({"brdf, local/roughconductor",
                          "most renders miss light that one sample in several hundred renders "
                          "finds; the mean of 2,000 renders is correct"});
  return c;
}

Case point_lights() {
  Case c{22,
         "VPLs: in the shading point's cluster, at no distance, all unlit",
         "Peaks near points are kept, and unbiased; a point in a surface's plane doesn't light it; "
         "without lit points there is no bounce.",
         "render/direct/vpl_test.cpp plugins/integrators/kernels/local_cut_test.cpp",
         {}};
  Trial unlit = bounce(
      "lamp that shines away: all points unlit", {0, -3, 1.5f}, {0, 0, .3f}, 40, corner,
      xml::emitter("spot", xml::to_world(xml::look_at({-.2f, 0, 1}, {-.2f, 0, 5}, {0, 1, 0})) +
                               xml::number("cutoff_angle", 30)));
  unlit.expectation.kind = Expectation::Kind::kBlack;
  unlit.renders = 2;
  c.trials = {
      unlit,
      bounce(
          "a strip a thousandth wide beside the floor", {0, -2, 1}, {0, 0, 0}, 40,
          [](const std::string& bsdf) {
            return wall(xml::scale(Vec3(1, 5e-4f, 1)) + xml::rotate({1, 0, 0}, 90) +
                            xml::translate({0, .3f, 5e-4f}),
                        bsdf) +
                   wall("", bsdf);
          },
          point_xml({0, -.3f, .7f}, {1, 2, 3})),
      bounce(
          "one triangle of a floor, nothing to bounce off", {0, -2, 1}, {0, 0, 0}, 40,
          [](const std::string& bsdf) { return wall("", bsdf); },
          point_xml({0, -.3f, .7f}, {1, 2, 3})),
  };
  return c;
}

Case many() {
  Case c{23,
         "Coincident lights; 1 light; 2^22 lights; radiances of 1e-30 to 1e30 in one scene",
         "Trees sum in double precision; coincident lights are kept as separate points.",
         "plugins/integrators/clustered/light_tree_test.cpp plugins/integrators/kernels/local_cut_test.cpp stability/precision_test.cpp "
         "render/direct/vpl_test.cpp",
         {}};
  const glm::dvec3 place(.2, .1, .8);
  const Rgb intensity(3, 2, 1);
  c.trials.push_back(over_the_floor("one light", point_xml(Vec3(place), intensity),
                                    point_light(place, intensity)));
  std::string lamps;
  for (int i = 0; i < 50; ++i) lamps += point_xml(Vec3(place), intensity / 50.f);
  c.trials.push_back(over_the_floor("50 lights in one place, of a 50th of the power each", lamps,
                                    point_light(place, intensity)));
  lamps.clear();
  std::vector<FloorLight> lights;
  for (int i = 0; i < 9; ++i) {
    const glm::dvec3 p(.5 * std::cos(i), .5 * std::sin(i), .4 + .1 * i);
    const Rgb power = intensity * std::pow(10.f, -30 + 7.5f * static_cast<float>(i));
    lamps += point_xml(Vec3(p), power);
    lights.push_back(point_light(p, power));
  }
  c.trials.push_back(over_the_floor("nine lights of 1e-30 to 1e30", lamps, sum_of(lights)));
  Trial rooms = bounce(
      "a bounce of four lights of 1e-20 to 1e10", {2.5f, -2.5f, 2.f}, {-.4f, .4f, .5f}, 45, corner,
      point_xml({-.2f, .1f, 1.2f}, intensity * 1e-20f) +
          point_xml({-.3f, .2f, 1.1f}, intensity * 1e-10f) +
          point_xml({-.2f, .3f, 1.f}, intensity) + point_xml({-.4f, .1f, .9f}, intensity * 1e10f));
  c.trials.push_back(rooms);
  return c;
}

}  // namespace

std::vector<Case> lamp_cases(const std::string& /*folder*/) {
  return {clusters(), cones(), tiny_lamps(), parameters(), point_lights(), many()};
}

}  // namespace kinome::test
