// Light from infinitely far: black, extreme and degenerate maps over a bare floor, against
// quadrature of the map as documented.
#include <cmath>

#include "matrix.h"
#include "xml.h"
#include "kinome/image_files.h"

namespace kinome::test {
namespace {

/// Rotation of a map, for the scene and for the integral.
struct Turn {
  std::string operations;
  glm::dmat3 matrix;
};
glm::dmat3 about_x(double degrees) {
  const double a = glm::radians(degrees);
  return {{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}};
}
glm::dmat3 about_y(double degrees) {
  const double a = glm::radians(degrees);
  return {{std::cos(a), 0, -std::sin(a)}, {0, 1, 0}, {std::sin(a), 0, std::cos(a)}};
}
/// Rotates first about x, then about y.
Turn turned(double x, double y) {
  return {xml::rotate({1, 0, 0}, x) + xml::rotate({0, 1, 0}, y), about_y(y) * about_x(x)};
}
Turn pole_up() {
  return turned(90, 0);
}  ///< row 0 above the floor
Turn pole_down() {
  return turned(-90, 0);
}  ///< the last row above the floor
Turn on_its_side() {
  return turned(0, 0);
}  ///< the middle column above the floor
Turn seam_up() {
  return turned(0, 180);
}  ///< where the last column meets the first

Floor even_floor() {
  Floor floor;
  floor.is_even = true;
  return floor;
}

class Maps {
 public:
  explicit Maps(std::string folder) : folder_(std::move(folder)) {}

  /// A map over the bare floor.
  Trial trial(const std::string& name, int width, int height,
              const std::function<Rgb(int x, int y)>& texel, const Turn& turn = pole_up(),
              const std::string& more = "") {
    const MapLight map = MapLight::of(width, height, texel, turn.matrix);
    const std::string file = write(map.image());
    Trial t;
    t.name = name;
    t.has_environment = true;
    t.scene = [=](const std::string& bsdf) {
      return even_floor().sensor_xml() + even_floor().shape_xml(bsdf) +
             xml::emitter("envmap",
                          xml::text("filename", file) + xml::to_world(turn.operations) + more);
    };
    t.expectation.kind = Expectation::Kind::kIntegral;
    t.expectation.integral = [=](const std::string& bsdf) {
      return even_floor().expected(bsdf, map.light());
    };
    return t;
  }

  /// A map with an invalid texel.
  Trial refused(const std::string& name, float value, std::vector<std::string> words,
                bool half = false) {
    MapLight map = MapLight::of(6, 4, [](int, int) { return Rgb(1.f); });
    Image image = map.image();
    image.at(3, 2, 1) = value;
    const std::string file = folder_ + "/refused" + std::to_string(count_++) + ".exr";
    write_exr(file, image, half ? ExrSampleType::kHalf : ExrSampleType::kFloat, {});
    Trial t;
    t.name = name;
    t.has_environment = true;
    t.scene = [=](const std::string& bsdf) {
      return even_floor().sensor_xml() + even_floor().shape_xml(bsdf) +
             xml::emitter("envmap", xml::text("filename", file));
    };
    t.expectation.kind = Expectation::Kind::kError;
    t.expectation.error = std::move(words);
    t.materials.resize(1);
    return t;
  }

 private:
  std::string write(const Image& image) {
    const std::string file = folder_ + "/map" + std::to_string(count_++) + ".pfm";
    write_pfm(file, image);
    return file;
  }
  std::string folder_;
  int count_ = 0;
};

/// A different value in each texel, with channels in three times 0.1 to 1.5.
Rgb noise(int x, int y) {
  const auto unit = [&](int c) { return static_cast<float>((x * 7 + y * 13 + c * 5) % 11); };
  return 0.125f * Rgb(1 + unit(0), 1 + unit(1), 1 + unit(2));
}
std::function<Rgb(int x, int y)> sun_at(int sun_x, int sun_y, const Rgb& sun, const Rgb& sky) {
  return [=](int x, int y) { return x == sun_x && y == sun_y ? sun : sky; };
}

Trial even_trial(const std::string& name, const Rgb& radiance) {
  Trial t;
  t.name = name;
  t.has_environment = true;
  t.scene = [=](const std::string& bsdf) {
    return even_floor().sensor_xml() + even_floor().shape_xml(bsdf) +
           xml::emitter("constant", xml::color("radiance", radiance));
  };
  t.expectation.kind = Expectation::Kind::kIntegral;
  t.expectation.integral = [=](const std::string& bsdf) {
    return even_floor().expected(bsdf, even_light(radiance));
  };
  return t;
}

Case black(Maps& maps) {
  Case c{1,
         "Black environment, all-black scene",
         "The image is black.",
         "render/direct/closed_form_test.cpp render/product/product_properties_test.cpp render/direct/local_light_test.cpp",
         {}};
  const auto add = [&](Trial trial) {
    trial.expectation.kind = Expectation::Kind::kBlack;
    trial.renders = 2;
    c.trials.push_back(std::move(trial));
  };
  add(even_trial("black constant light", Rgb(0.f)));
  add(maps.trial("black map", 4, 3, [](int, int) { return Rgb(0.f); }));
  Trial dark = even_trial("no emitter", Rgb(1.f));
  dark.has_environment = false;
  dark.scene = [](const std::string& bsdf) {
    return even_floor().sensor_xml() + even_floor().shape_xml(bsdf);
  };
  add(dark);
  Trial surfaces = even_trial("black surfaces under an even light", Rgb(1.f));
  const std::string none =
      xml::number("diffuse_reflectance", 0) + xml::number("specular_reflectance", 0);
  surfaces.materials = {
      {"diffuse", xml::bsdf("diffuse", xml::number("reflectance", 0))},
      {"phong", xml::bsdf("phong", none)},
      {"ward", xml::bsdf("ward", none)},
      {"roughconductor", xml::bsdf("roughconductor", xml::number("specular_reflectance", 0))},
      {"roughplastic", xml::bsdf("roughplastic", none)}};
  add(surfaces);
  return c;
}

Case sizes(Maps& maps) {
  Case c{2,
         "Constant and tiny maps with MIS compensation; huge maps",
         "Compensation keeps a sixteenth of every texel's density, so that none is 0.",
         "statistical/envmap_sampling_test.cpp render/product/product_properties_test.cpp",
         {}};
  const std::string compensated = xml::boolean("mis_compensation", true);
  c.trials = {
      even_trial("constant", {1, .8f, .5f}),
      maps.trial(
          "even map, compensated", 16, 9, [](int, int) { return Rgb(1, .8f, .5f); }, pole_up(),
          compensated),
      maps.trial("noise, compensated", 16, 9, noise, pole_up(), compensated),
      maps.trial("1 x 1", 1, 1, noise, pole_up(), compensated),
      maps.trial("2 x 2", 2, 2, noise),
      maps.trial("1 x 7", 1, 7, noise),
      maps.trial("7 x 1", 7, 1, noise, on_its_side(), compensated),
  };
  // Light paths rarely find the lobes of roughplastic: means of fewer renders aren't normal.
  trial_named(c, "noise, compensated").renders *= 8;
  // The map varies only by row and linearly, so that a map of two rows has the same expectation.
  const auto line = [](int rows) {
    return [=](int, int y) {
      const float t = static_cast<float>(y) / static_cast<float>(rows - 1);
      return Rgb(1 - t, 0.5f, 0.1f + t);
    };
  };
  Trial huge = maps.trial("8192 x 4096", 8192, 4096, line(4096));
  const MapLight small = MapLight::of(1, 2, line(2), pole_up().matrix);
  huge.expectation.integral = [=](const std::string& bsdf) {
    return even_floor().expected(bsdf, small.light());
  };
  huge.materials.resize(2);
  huge.renders = 16;
  huge.is_long = true;
  c.trials.push_back(huge);
  return c;
}

Case poles(Maps& maps) {
  Case c{3,
         "A sun on the pole",
         "The density between rows is proportional to the map, even where sines are 0.",
         "statistical/envmap_sampling_test.cpp render/direct/closed_form_test.cpp",
         {}};
  const Rgb sun(900, 700, 500), sky(.1f, .2f, .3f);
  c.trials = {
      maps.trial("sun at the upper pole", 16, 9, sun_at(5, 0, sun, sky)),
      maps.trial("lone sun at the upper pole", 8, 33, sun_at(3, 0, sun, Rgb(0.f))),
      maps.trial("lone sun beside it", 8, 33, sun_at(3, 1, sun, Rgb(0.f))),
      maps.trial("sun at the lower pole", 16, 9, sun_at(0, 8, sun, sky), pole_down()),
      maps.trial("bright ring around a black pole", 8, 17,
                 [](int, int y) { return Rgb(y == 1 ? 100.f : 0.f); }),
  };
  return c;
}

Case seams(Maps& maps) {
  Case c{4,
         "Half-texel offsets and the seam of phi",
         "phi is measured from texel centres, and theta from pole to pole, in evaluation, "
         "sampling, cells and points.",
         "statistical/envmap_test.cpp render/direct/closed_form_test.cpp",
         {}};
  const Rgb sun(300, 200, 100);
  c.trials = {
      maps.trial("sun left of the seam", 64, 33, sun_at(63, 15, sun, Rgb(0.f)), seam_up()),
      maps.trial("sun right of the seam", 64, 33, sun_at(0, 17, sun, Rgb(0.f)), seam_up()),
      maps.trial("sun in the middle", 64, 33, sun_at(31, 16, sun, Rgb(0.f)), on_its_side()),
      maps.trial(
          "stripes across the seam", 5, 9, [](int x, int) { return Rgb(x == 0, x == 4, .1f); },
          seam_up()),
  };
  return c;
}

Case texels(Maps& maps) {
  Case c{5,
         "Negative texels; NaN, Inf; half floats that overflow",
         "Negative texels are kept; NaN becomes 0 and infinity the largest value, with a warning.",
         "statistical/envmap_test.cpp plugins/textures/texture_test.cpp",
         {}};
  c.trials = {
      maps.trial(
          "some negative texels", 16, 9,
          [](int x, int y) { return noise(x, y) - ((x + y) % 5 == 0 ? Rgb(1.5f) : Rgb(0.f)); }),
      maps.trial("all negative", 4, 4, [](int x, int y) { return -noise(x, y); }),
      maps.refused("a texel whose square overflows", 1e37f, {"too large", "1e36"}),
  };
  for (Trial& t : c.trials) {
    if (t.name == "all negative") t.without.push_back({"ptracer", "it emits no negative light"});
  }
  return c;
}

Case suns(Maps& maps) {
  Case c{6,
         "A sun smaller than a texel; several suns; their edges",
         "Sampling uses the same bilinear interpolation as evaluation.",
         "render/direct/closed_form_test.cpp statistical/envmap_sampling_test.cpp",
         {}};
  c.trials = {
      maps.trial("one texel of 512 x 257", 512, 257,
                 sun_at(100, 40, Rgb(1e6f, 9e5f, 7e5f), Rgb(.1f, .2f, .4f))),
      maps.trial("four suns", 128, 65,
                 [](int x, int y) {
                   if (x == 10 && y == 9) return Rgb(2000, 0, 0);
                   if (x == 11 && y == 9) return Rgb(0, 3000, 0);
                   if (x == 80 && y == 20) return Rgb(500, 500, 4000);
                   if (x == 127 && y == 31) return Rgb(900);
                   return Rgb(.05f);
                 }),
      maps.trial("bright band", 64, 33,
                 [](int, int y) { return y == 6 ? Rgb(50, 30, 20) : Rgb(.01f); }),
  };
  trial_named(c, "one texel of 512 x 257")
      .without.push_back({"ptracer/roughconductor",
                          "metal shows the sky, where only one in hundreds of light paths "
                          "starts; with 262,144 paths the image is correct"});
  return c;
}

Case resolutions(Maps& maps) {
  Case c{7,
         "Sampling table and texture of different resolution",
         "There is one resolution: the table is built from the map's texels.",
         "statistical/envmap_sampling_test.cpp",
         {}};
  c.trials = {
      maps.trial(
          "checkerboard of 0 and 1000, turned", 256, 129,
          [](int x, int y) { return (x + y) % 2 ? Rgb(1000.f) : Rgb(0.f); }, turned(50, 20)),
      maps.trial(
          "every 37th texel", 256, 129,
          [](int x, int y) { return (x + 256 * y) % 37 == 0 ? Rgb(900, 500, 100) : Rgb(0.f); },
          turned(50, 20)),
  };
  return c;
}

Case horizons(Maps& maps) {
  Case c{10,
         "Approximate and exact cosines in one comparison",
         "The evaluated cosines decide which cells and clusters straddle the horizon.",
         "plugins/integrators/kernels/light_cut_test.cpp render/product/product_places_test.cpp",
         {}};
  c.trials = {
      maps.trial("bright band on the horizon", 64, 33,
                 [](int, int y) { return Rgb(std::abs(y - 16) <= 1 ? 30.f : .1f); }),
      maps.trial("sun half below the horizon", 64, 33,
                 sun_at(20, 16, Rgb(3000, 2000, 1000), Rgb(0.f))),
      maps.trial(
          "horizon through cells, turned", 64, 33,
          [](int x, int y) { return x % 8 == 0 ? Rgb(40.f) : noise(x, y); }, turned(23, 11)),
  };
  trial_named(c, "bright band on the horizon").rarely_lit = {"ptracer/roughconductor"};
  trial_named(c, "sun half below the horizon").rarely_lit = {"ptracer"};
  return c;
}

}  // namespace

std::vector<Case> light_cases(const std::string& folder) {
  Maps maps(folder);
  return {black(maps),  sizes(maps), poles(maps),       seams(maps),
          texels(maps), suns(maps),  resolutions(maps), horizons(maps)};
}

}  // namespace kinome::test
