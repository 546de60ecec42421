// Surfaces, cameras and samplers: extreme roughness, geometry, positions and sizes.
#include <cmath>
#include <functional>

#include "surface_scenes.h"

namespace kinome::test {
namespace {

Case normals(const Files& files) {
  Case c{11,
         "Sampling and MIS with different normals; f != 0 where pdf = 0",
         "Only the shading normal is used; sampling covers its whole hemisphere.",
         "statistical/bsdf_extremes_test.cpp statistical/bsdf_chi2_test.cpp",
         {}};
  const std::string ball = ball_obj(0), bent = ball_obj(.7f);
  c.trials.push_back(picture(
      "faceted ball with smooth normals, panel and sky",
      [=](const std::string& bsdf) {
        return front_view() + files.mesh(ball, xml::to_world(xml::translate({0, 0, 1})) + bsdf) +
               panel() + constant();
      },
      samples(0, 1), true, true));
  c.trials.push_back(picture(
      "ball with bent normals under a sky",
      [=](const std::string& bsdf) {
        return front_view() + files.mesh(bent, xml::to_world(xml::translate({0, 0, 1})) + bsdf) +
               constant();
      },
      samples(0, 1), true, false));
  Image map{8, 8, {"R", "G", "B"}, {}};
  const Vec3 tilted[4] = {{.6f, 0, .8f}, {0, 0, 1}, {-.5f, -.3f, .8f}, {0, .8f, .6f}};
  for (int i = 0; i < 64; ++i) {
    const Vec3 colour = 0.5f * (glm::normalize(tilted[(i + i / 8) % 4]) + 1.f);
    map.data.insert(map.data.end(), {colour.x, colour.y, colour.z});
  }
  const std::string file = files.image(map);
  const auto mapped = [=](const std::string& bsdf) {
    return xml::bsdf("normalmap", "<texture type='bitmap' name='normalmap'>" +
                                      xml::text("filename", file) + xml::boolean("raw", true) +
                                      "</texture>" + bsdf);
  };
  c.trials.push_back(picture(
      "normal map of 40 degrees under a sky",
      [=](const std::string& bsdf) { return front_view() + still_life(mapped(bsdf)) + constant(); },
      samples(0, 1), true, false));
  c.trials.back().rarely_lit = {"ptracer/roughconductor"};
  return c;
}

Case bounds() {
  Case c{12,
         "Infinite importance from unbounded boxes; overflow of indices",
         "Boxes are those of existing points; sums and indices support 2^24 points.",
         "plugins/integrators/clustered/light_tree_test.cpp render/product/product_properties_test.cpp",
         {}};
  c.trials.push_back(picture(
      "a floor of 1e15 below the still life",
      [](const std::string& bsdf) {
        return front_view() + still_life(bsdf) +
               xml::shape("rectangle",
                          xml::to_world(xml::scale(1e15) + xml::translate({0, 0, -1})) + bsdf) +
               constant();
      },
      samples(0, 1), true, false));
  c.trials.back().without.push_back(
      {"ptracer", "its light paths are spread over an area of 1e30 square units"});
  return c;
}

Case edges(const Files& files) {
  Case c{13,
         "Random numbers reused until they reach 1",
         "No random number is used twice; those at the ends of [0, 1) give finite images.",
         "statistical/bsdf_extremes_test.cpp libs/distribution_test.cpp plugins/integrators/kernels/light_cut_test.cpp",
         {}};
  const std::string edgy = front_view(1, Vec3(0.f), "edges", 16);
  const auto add = [&](const std::string& name, const std::string& lights, bool environment) {
    Trial t = picture(
        name, [=](const std::string& bsdf) { return edgy + still_life(bsdf) + lights; }, "",
        environment, true);
    t.expectation.kind = Expectation::Kind::kFinite;
    t.renders = 8;
    c.trials.push_back(t);
  };
  add("numbers at the ends, even sky", constant(), true);
  Image map{4, 3, {"R", "G", "B"}, {}};
  for (int i = 0; i < 12; ++i) {
    const float v = i % 3 == 0 ? 0.f : static_cast<float>(i);
    map.data.insert(map.data.end(), {v, 2 * v, v * v});
  }
  add("numbers at the ends, map with black texels",
      xml::emitter("envmap", xml::text("filename", files.image(map))), true);
  add("numbers at the ends, panel and lamp", panel() + lamp(), false);
  return c;
}

Case roughness() {
  Case c{14,
         "alpha of 0, 1e-9 and 1e-5, for both axes or one; Phong exponents of 0 and 1e6",
         "alpha is at least 1e-4, as in Mitsuba; an exponent of 0 is the widest lobe.",
         "statistical/bsdf_extremes_test.cpp plugins/bsdfs/bsdf_parameters_test.cpp",
         {}};
  const auto metal = [](const std::string& distribution, double u, double v) {
    return xml::bsdf("roughconductor", xml::text("distribution", distribution) +
                                           xml::number("alpha_u", u) + xml::number("alpha_v", v));
  };
  Trial even = picture(
      "extreme roughness under an even sky",
      [](const std::string& bsdf) { return front_view() + still_life(bsdf) + constant(); },
      samples(0, 1), true, false);
  even.materials = {
      {"roughconductor 0", metal("beckmann", 0, 0), true},
      {"roughconductor 1e-9, ggx", metal("ggx", 1e-9, 1e-9), true},
      {"roughconductor 1e-5", metal("beckmann", 1e-5, 1e-5), true},
      {"roughconductor 0 and 0.5", metal("beckmann", 0, .5), true},
      {"roughconductor 0.5 and 0, ggx", metal("ggx", .5, 0), true},
      {"phong 0", xml::bsdf("phong", xml::number("exponent", 0))},
      {"phong 1e6", xml::bsdf("phong", xml::number("exponent", 1e6)), true},
      {"ward 0", xml::bsdf("ward", xml::number("alpha", 0)), true},
      {"ward 1e-5 and 0.5",
       xml::bsdf("ward", xml::number("alpha_u", 1e-5) + xml::number("alpha_v", .5)), true},
      {"roughplastic 0", xml::bsdf("roughplastic", xml::number("alpha", 0)), true},
      {"roughplastic 1e-5, ggx",
       xml::bsdf("roughplastic", xml::text("distribution", "ggx") + xml::number("alpha", 1e-5)),
       true},
  };
  c.trials.push_back(even);
  return c;
}

Case angles(const Files& files) {
  Case c{16,
         "wi = wo; grazing and back-facing shading normals; the terminator",
         "Light from behind the camera, along the floor, and beyond a face's horizon.",
         "statistical/bsdf_extremes_test.cpp plugins/bsdfs/bsdf_reference_test.cpp",
         {}};
  const auto parallel = [&](const std::string& name, const glm::dvec3& toward_light,
                            const glm::dvec3& toward_camera) {
    Floor floor;
    floor.toward_camera = toward_camera;
    floor.half_width = 0.5 * std::min(1., 2 * glm::normalize(toward_camera).z);
    const Rgb irradiance(3, 2, 1);
    Trial t;
    t.name = name;
    t.has_lamps = true;
    t.scene = [=](const std::string& bsdf) {
      return floor.sensor_xml() + floor.shape_xml(bsdf) +
             xml::emitter("directional", xml::vector("direction", Vec3(-toward_light)) +
                                             xml::color("irradiance", irradiance));
    };
    t.expectation.kind = Expectation::Kind::kIntegral;
    t.expectation.integral = [=](const std::string& bsdf) {
      return floor.expected(bsdf, parallel_light(-toward_light, irradiance));
    };
    c.trials.push_back(t);
  };
  const glm::dvec3 slant(.5, .3, .8);
  parallel("light from the camera", slant, slant);
  parallel("light and camera above", {0, 0, 1}, {0, 0, 1});
  parallel("light along the floor", {1, 0, 1e-4}, slant);
  c.trials.back().without.push_back(
      {"ptracer", "one in 10^4 of its paths hits the visible surface"});
  parallel("camera along the floor", slant, {.7, .7, .01});
  parallel("both along the floor, face to face", {-1, 0, .01}, {1, 0, .01});
  c.trials.back().without.push_back(
      {"ptracer", "one in 10^5 of its paths hits the visible surface"});
  // A cosine of .01 has a relative error of 6e-6 for a direction in floats, and a mirroring lobe
  // has two.
  c.trials.back().rounding = 1e-5;
  const std::string ball = ball_obj(0);
  c.trials.push_back(picture(
      "terminator of a faceted ball",
      [=](const std::string& bsdf) {
        return front_view() + files.mesh(ball, xml::to_world(xml::translate({0, 0, 1})) + bsdf) +
               xml::emitter("directional", xml::vector("direction", Vec3(-1, .3f, -.2f)));
      },
      integrator_of_depth("ptracer", 2), false, true));
  return c;
}

Case places() {
  Case c{17,
         "Self-intersection far away, tiny and huge; offsets wider than a gap",
         "Offsets are proportional to the rounding error of each hit.",
         "plugins/shapes/self_intersection_test.cpp "
         "stability/invariance_test.cpp",
         {}};
  const auto add = [&](const std::string& name, double scale, const Vec3& offset) {
    const std::string operations = xml::scale(scale) + xml::translate(offset);
    for (const bool sky : {true, false}) {
      Trial t = picture(
          name + (sky ? ", sky" : ", panel"),
          [=](const std::string& bsdf) {
            return front_view(scale, offset) + still_life(bsdf, operations) +
                   (sky ? constant() : panel(operations));
          },
          samples(0, 1), sky, !sky);
      t.expectation.scene = [=](const std::string& bsdf) {
        return front_view() + still_life(bsdf) + (sky ? constant() : panel());
      };
      // A panel's shadow by BSDF samples alone is noisy.
      if (!sky) t.expectation.integrator = samples(1, 0);
      if (sky) t.rarely_lit = {"ptracer/ward", "ptracer/roughconductor"};
      c.trials.push_back(t);
    }
  };
  add("a millionth", 1e-6, Vec3(0.f));
  add("a million times", 1e6, Vec3(0.f));
  add("a hundred times, 1e5 away", 100, Vec3(1e5f, -1e5f, 1e5f));
  return c;
}

Case triangles(const Files& files) {
  Case c{18,
         "Triangles without area; needles; leaks at edges",
         "They are kept, and receive no light; Embree's robust mode closes the edges.",
         "plugins/shapes/mesh_files_test.cpp plugins/shapes/self_intersection_test.cpp "
         "statistical/shape_sampling_test.cpp",
         {}};
  // A square floor with degenerate faces (points, lines) and needles of 1e-7.
  const std::string square =
      "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 0\nv 0.5 0.5 0\nv 0.9999999 1 0\n"
      "f 1 2 3\nf 1 3 4\nf 1 1 1\nf 2 2 3\nf 1 5 6\nf 1 5 3\nf 1 7 3\n";
  Floor floor;
  floor.is_even = false;
  Trial lit;
  lit.name = "floor of such triangles";
  lit.has_lamps = true;
  lit.scene = [=](const std::string& bsdf) {
    return floor.sensor_xml() + files.mesh(square, bsdf) +
           xml::emitter("point", xml::point("position", {.2f, .1f, .9f}) +
                                     xml::color("intensity", Rgb(3, 2, 1)));
  };
  lit.expectation.kind = Expectation::Kind::kIntegral;
  lit.expectation.integral = [=](const std::string& bsdf) {
    return floor.expected(bsdf, point_light({.2, .1, .9}, Rgb(3, 2, 1)));
  };
  // Anisotropic lobes are aligned with (u, v), which this mesh lacks.
  std::erase_if(lit.materials, [](const Material& m) { return m.name == "ward"; });
  c.trials.push_back(lit);
  Trial lamp_trial = lit;
  lamp_trial.name = "light of such triangles";
  lamp_trial.materials = ordinary_materials();
  lamp_trial.scene = [=](const std::string& bsdf) {
    return floor.sensor_xml() + floor.shape_xml(bsdf) +
           files.mesh(square, xml::to_world(xml::scale(.3) + xml::rotate({1, 0, 0}, 180) +
                                            xml::translate({0, 0, 1.2f})) +
                                  xml::emitter("area", xml::color("radiance", Rgb(3, 5, 9))));
  };
  lamp_trial.expectation.integral = [=](const std::string& bsdf) {
    return floor.expected(bsdf, square_light({0, 0, 1.2}, {.3, 0, 0}, {0, -.3, 0}, Rgb(3, 5, 9)));
  };
  c.trials.push_back(lamp_trial);
  return c;
}

Case sides(const Files& files) {
  Case c{19,
         "Flipped and one-sided geometry; mirroring transforms with vertex normals",
         "Faces and normals are flipped together.",
         "plugins/shapes/shape_conventions_test.cpp plugins/shapes/mesh_files_test.cpp",
         {}};
  const std::string ball = ball_obj(0);
  const auto mirrored = [&](const std::string& name, const std::string& mirror) {
    Trial t = picture(
        name,
        [=](const std::string& bsdf) {
          return front_view() +
                 files.mesh(ball, xml::to_world(mirror + xml::translate({0, 0, 1})) + bsdf) +
                 panel() + lamp();
        },
        samples(1, 0), false, true);
    t.expectation.scene = [=](const std::string& bsdf) {
      return front_view() + files.mesh(ball, xml::to_world(xml::translate({0, 0, 1})) + bsdf) +
             panel() + lamp();
    };
    std::erase_if(t.materials, [](const Material& m) { return m.name == "ward"; });
    c.trials.push_back(t);
  };
  mirrored("ball mirrored in x", xml::scale(Vec3(-1, 1, 1)));
  mirrored("ball mirrored in all axes", xml::scale(Vec3(-1.f)));
  Floor floor;
  floor.is_even = false;
  const auto over_floor = [&](const std::string& name, const std::string& inner, bool is_black) {
    Trial t;
    t.name = name;
    t.has_lamps = true;
    t.scene = [=](const std::string& bsdf) {
      return floor.sensor_xml() + xml::shape("rectangle", inner + bsdf) +
             xml::emitter("point", xml::point("position", {.2f, .1f, .9f}) +
                                       xml::color("intensity", Rgb(3, 2, 1)));
    };
    t.expectation.kind = is_black ? Expectation::Kind::kBlack : Expectation::Kind::kIntegral;
    if (is_black) t.renders = 2;
    t.expectation.integral = [=](const std::string& bsdf) {
      return floor.expected(bsdf, point_light({.2, .1, .9}, Rgb(3, 2, 1)));
    };
    c.trials.push_back(t);
  };
  const std::string flipped = xml::boolean("flip_normals", true);
  over_floor("floor seen from behind", flipped, true);
  over_floor("floor turned over", xml::to_world(xml::rotate({0, 1, 0}, 180)), true);
  over_floor("floor turned over and flipped", xml::to_world(xml::rotate({0, 1, 0}, 180)) + flipped,
             false);
  return c;
}

Case empty_cells() {
  Case c{21,
         "Learned caches in empty cells, or of a fixed radius in a huge scene",
         "Patches are parts of the image, not of the world; cells without learned visibility get "
         "rays.",
         "render/product/product_places_test.cpp render/product/product_learning_test.cpp",
         {}};
  c.trials.push_back(picture(
      "a ball of a thousandth alone in the sky",
      [](const std::string& bsdf) {
        return front_view() +
               xml::shape(
                   "sphere",
                   xml::to_world(xml::scale(1e-3) + xml::translate({.02f, 0, .41f})) + bsdf) +
               constant();
      },
      samples(0, 1), true, false));
  c.trials.back().rarely_lit = {"ptracer"};
  c.trials.push_back(picture(
      "the still life, and a floor that ends 1e6 away",
      [](const std::string& bsdf) {
        return front_view() + still_life(bsdf) +
               xml::shape("rectangle",
                          xml::to_world(xml::scale(1e6) + xml::translate({0, 0, -.5f})) + bsdf) +
               constant();
      },
      samples(0, 1), true, false));
  c.trials.back().without.push_back(
      {"ptracer", "its light paths are spread over an area of 1e12 square units"});
  return c;
}

}  // namespace

std::vector<Case> surface_cases(const std::string& folder) {
  const Files files(folder);
  return {normals(files), bounds(),         edges(files), roughness(),  angles(files),
          places(),       triangles(files), sides(files), empty_cells()};
}

}  // namespace kinome::test
