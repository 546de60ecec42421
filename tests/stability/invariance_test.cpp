// Transformations that must not change an image: units of length and of light, translation and
// rotation of the world, order of triangles, number of shapes, mirroring, and division of an
// emitter into several. With every integrator and importance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "measure.h"
#include "support/render.h"
#include "xml.h"
#include "kinome/image_files.h"

namespace kinome::test::invariance_test {
namespace {

/// False-alarm rate of each of about 120 comparisons.
constexpr double kAlpha = 1e-6;
constexpr int kRenders = 32, kTiles = 3;

struct Renderer {
  const char* name;
  std::string xml;
};
std::string clustered(const std::string& importance, int max_depth) {
  return xml::integrator("clustered",
                         xml::text("importance", importance) + xml::integer("light_samples", 200) +
                             xml::integer("cut_size", 30) + xml::integer("emitter_samples", 8) +
                             xml::integer("brdf_samples", 8) + xml::number("rays_per_pixel", 12) + xml::boolean("trial", false) +
                             xml::integer("max_depth", max_depth));
}
const std::vector<Renderer>& renderers() {
  static const std::vector<Renderer> all = {
      {"direct", xml::integrator("direct")},
      {"path", xml::integrator("path", xml::integer("max_depth", 4))},
      {"ptracer", xml::integrator("ptracer", xml::integer("max_depth", 3))},
      {"groundtruth", xml::integrator("groundtruth", xml::integer("light_samples", 200) +
                                                         xml::integer("max_depth", 2))},
      {"joint", clustered("joint", 2)},
      {"luminance", clustered("luminance", 2)},
      {"brdf", clustered("brdf", 2)},
      {"product", clustered("product", 2)},
      {"joint, local", clustered("joint", 3)},
      {"product, local", clustered("product", 3)},
  };
  return all;
}

enum class Light { kSky, kLamp, kPanel };

/// A ball and a block on a floor, and a transformation of the whole scene.
struct World {
  Light light = Light::kLamp;
  std::string turn;       ///< rotation of the whole scene, before scale and translation
  double length = 1;      ///< length of a unit
  Vec3 offset{0.f};       ///< position of the origin
  double brightness = 1;  ///< factor of all light
  int lamps = 1;          ///< number of lamps in one position, with the same total power
  std::string ball;       ///< shapes instead of the sphere
  /// Mitsuba's convention: a mirroring transform turns a sphere inside out.
  bool is_mirrored = false;

  std::string operations() const {
    return turn + (length == 1 ? "" : xml::scale(length)) + xml::translate(offset);
  }
  /// A camera must not be scaled itself.
  std::string view() const {
    const auto unit = static_cast<float>(length);
    return xml::look_at(unit * Vec3(0, -4, 2), unit * Vec3(0, 0, .4f), {0, 0, 1}) + turn +
           xml::translate(offset);
  }

  std::string xml(const std::string& integrator) const {
    const auto placed = [&](const std::string& type, const std::string& own,
                            const std::string& bsdf) {
      return xml::shape(type, xml::to_world(own + operations()) + bsdf);
    };
    const std::string plastic = xml::bsdf("roughplastic", xml::number("alpha", .25));
    const std::string grey = xml::bsdf("diffuse", xml::color("reflectance", {.6f, .5f, .4f}));
    return xml::scene(
        integrator +
        xml::sensor("perspective", view(), 12, 12, 1, "independent",
                    xml::number("fov", 35) + xml::number("near_clip", .01 * length) +
                        xml::number("far_clip", 1e3 * length)) +
        (ball.empty() ? placed("sphere", xml::scale(.5) + xml::translate({-.5f, 0, .5f}),
                               plastic + (is_mirrored ? xml::boolean("flip_normals", true) : ""))
                      : ball) +
        placed("cube",
               xml::scale(Vec3(.25f, .3f, .4f)) + xml::rotate({0, 0, 1}, 30) +
                   xml::translate({.6f, .2f, .4f}),
               grey) +
        placed("rectangle", xml::scale(Vec3(2, 2, 1)), grey) + lights());
  }

 private:
  std::string lights() const {
    const auto power = static_cast<float>(brightness / lamps);
    const auto area = static_cast<float>(length * length);
    std::string all;
    for (int i = 0; i < lamps; ++i) {
      switch (light) {
        case Light::kSky:
          all += xml::emitter("envmap", xml::text("filename", sky_file()) +
                                            xml::number("scale", power) + xml::to_world(turn));
          break;
        case Light::kLamp:
          all += xml::emitter(
              "spot",
              xml::to_world(xml::look_at({-.8f, -1, 2}, {0, 0, .3f}, {0, 0, 1}) + operations()) +
                  xml::color("intensity", Rgb(9, 7, 5) * power * area) +
                  xml::number("cutoff_angle", 60));
          break;
        case Light::kPanel:
          all += xml::shape(
              "rectangle", xml::to_world(xml::scale(.4) + xml::rotate({1, 0, 0}, 200) +
                                         xml::translate({.3f, -.4f, 2}) + operations()) +
                               xml::emitter("area", xml::color("radiance", Rgb(8, 9, 10) * power)));
      }
    }
    return all;
  }
  static const std::string& sky_file() {
    static const TemporaryFolder folder;
    static const std::string file = [] {
      Image image{16, 9, {"R", "G", "B"}, {}};
      for (int i = 0; i < 16 * 9; ++i) {
        const float v = i == 40 ? 100.f : 0.25f * static_cast<float>(1 + i % 7);
        image.data.insert(image.data.end(), {v, 0.75f * v, 0.5f * v});
      }
      write_pfm(folder.path("sky.pfm"), image);
      return folder.path("sky.pfm");
    }();
    return file;
  }
};

World lit_by(Light light) {
  World world;
  world.light = light;
  return world;
}
constexpr Light kLights[] = {Light::kSky, Light::kLamp, Light::kPanel};

std::string name_of(Light light) {
  return light == Light::kSky ? "sky" : light == Light::kLamp ? "lamp" : "panel";
}

Renders renders_of(const World& world, const Renderer& renderer, uint64_t seed,
                   int count = kRenders) {
  std::string integrator = renderer.xml;
  // `ptracer` doesn't show environments.
  integrator.insert(integrator.rfind("</"), xml::boolean("hide_emitters", true));
  const Renders renders = render_often(*scene_from(world.xml(integrator)), count, seed);
  EXPECT_EQ(renders.non_finite, 0u) << renderer.name;
  return renders;
}

/// Compares two images, within their noise. Many are compared with the same `a`.
void expect_same(const World& a, const World& b, const Renderer& renderer,
                 const std::string& what) {
  static std::map<std::string, std::vector<TileEstimate>> known;
  const auto [of_a, is_new] = known.try_emplace(a.xml(renderer.xml));
  if (is_new) of_a->second = estimate_tiles_of(renders_of(a, renderer, 1), kTiles);
  const Agreement agreement =
      compare(of_a->second, estimate_tiles_of(renders_of(b, renderer, 100'001), kTiles));
  EXPECT_GE(agreement.p, kAlpha) << what << ", " << renderer.name << ": z = " << agreement.worst_z
                                 << ", " << agreement.text;
}

/// All operations in single precision commute with powers of two within its range. In learned
/// sampling, products of light with fractions of it leave that range below 2^-90 (1e-27).
TEST(Invariance, LightTimesAPowerOfTwoScalesTheBits) {
  for (const Light light : kLights) {
    for (const Renderer& renderer : renderers()) {
      const Renders plain = renders_of(lit_by(light), renderer, 5, 1);
      const bool is_learned = std::string(renderer.name).starts_with("product");
      // 2^±100 are 1e30 and 1e-30.
      for (const int exponent : {is_learned ? -90 : -100, -20, 3, 40, 100}) {
        World world = lit_by(light);
        world.brightness = std::ldexp(1, exponent);
        const Renders scaled = renders_of(world, renderer, 5, 1);
        size_t differing = 0;
        for (size_t i = 0; i < plain.pixels[0].size(); ++i) {
          differing += scaled.pixels[0][i] != std::ldexp(plain.pixels[0][i], exponent);
        }
        EXPECT_EQ(differing, 0u) << name_of(light) << ", " << renderer.name << ", 2^" << exponent;
      }
    }
  }
}

/// The same without a power of two: rounding changes values, and sometimes choices.
TEST(Invariance, LightTimesANumberScalesTheImage) {
  for (const Renderer& renderer : renderers()) {
    World world = lit_by(Light::kSky);
    world.brightness = 1e-20;
    const Renders plain = renders_of(lit_by(Light::kSky), renderer, 1);
    Renders faint = renders_of(world, renderer, 100'001);
    for (auto& pixels : faint.pixels) {
      for (float& v : pixels) v *= 1e20f;
    }
    const Agreement agreement =
        compare(estimate_tiles_of(plain, kTiles), estimate_tiles_of(faint, kTiles));
    EXPECT_GE(agreement.p, kAlpha) << renderer.name << ": " << agreement.text;
  }
}

TEST(Invariance, UnitOfLength) {
  for (const Light light : kLights) {
    for (const Renderer& renderer : renderers()) {
      for (const double factor : {1e-6, 1e6}) {
        World world = lit_by(light);
        world.length = factor;
        expect_same(lit_by(light), world, renderer,
                    name_of(light) + " times " + xml::digits(factor));
      }
    }
  }
}

/// At 1e5, the spacing of floats is 1/128. The world is a hundred times as large there, and its
/// smallest parts are 25 units.
TEST(Invariance, PositionAndDirection) {
  const std::string turn = xml::rotate({0, 0, 1}, 77) + xml::rotate({1, 0, 0}, 140);
  for (const Light light : kLights) {
    for (const Renderer& renderer : renderers()) {
      World moved = lit_by(light), turned = lit_by(light);
      moved.length = 100;
      moved.offset = Vec3(1e5f, -1e5f, 1e5f);
      turned.turn = turn;
      expect_same(lit_by(light), moved, renderer, name_of(light) + " moved");
      expect_same(lit_by(light), turned, renderer, name_of(light) + " turned");
    }
  }
}

/// The mirrored world, seen by a mirrored camera.
TEST(Invariance, Handedness) {
  for (const Light light : kLights) {
    for (const Renderer& renderer : renderers()) {
      World mirrored = lit_by(light);
      mirrored.turn = xml::scale(Vec3(-1, 1, 1));
      mirrored.is_mirrored = true;
      expect_same(lit_by(light), mirrored, renderer, name_of(light) + " mirrored");
    }
  }
}

TEST(Invariance, LampsOfAShareOfThePower) {
  for (const Light light : {Light::kLamp, Light::kPanel}) {
    for (const Renderer& renderer : renderers()) {
      World parts = lit_by(light);
      parts.lamps = 2;
      expect_same(lit_by(light), parts, renderer, name_of(light) + " in two");
    }
  }
}

/// A ball of triangles, its faces in the order of `order`, from `first` up to `end`.
std::string ball_obj(const std::vector<int>& order, size_t first, size_t end) {
  constexpr int kColumns = 12, kRows = 6;
  std::string text;
  for (int row = 0; row <= kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const float theta = kPi * static_cast<float>(row) / kRows;
      const float phi = 2 * kPi * static_cast<float>(column) / kColumns;
      const Vec3 n(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                   std::cos(theta));
      text += "v " + xml::digits(.5f * n + Vec3(-.5f, 0, .5f)) + "\nvn " + xml::digits(n) + "\n";
    }
  }
  for (size_t k = first; k < end; ++k) {
    const int quad = order[k] / 2, row = quad / kColumns, column = quad % kColumns;
    const int a = row * kColumns + column + 1, b = row * kColumns + (column + 1) % kColumns + 1;
    const int c = b + kColumns, d = a + kColumns;
    text += order[k] % 2 ? fmt::format("f {0}//{0} {1}//{1} {2}//{2}\n", a, c, b)
                         : fmt::format("f {0}//{0} {1}//{1} {2}//{2}\n", a, d, c);
  }
  return text;
}

TEST(Invariance, OrderOfTrianglesAndNumberOfMeshes) {
  const TemporaryFolder folder;
  std::vector<int> order(2 * 12 * 6);
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::vector<int> permuted = order;
  std::shuffle(permuted.begin(), permuted.end(), std::mt19937(3));
  int files = 0;
  const auto mesh = [&](const std::vector<int>& faces, size_t first, size_t end) {
    const std::string file =
        folder.write(fmt::format("ball{}.obj", files++), ball_obj(faces, first, end));
    return xml::shape(
        "obj", xml::text("filename", file) + xml::bsdf("roughplastic", xml::number("alpha", .25)));
  };
  World whole = lit_by(Light::kLamp), shuffled = whole, split = whole;
  whole.ball = mesh(order, 0, order.size());
  shuffled.ball = mesh(permuted, 0, order.size());
  for (size_t i = 0; i < order.size(); i += 24) split.ball += mesh(permuted, i, i + 24);
  for (const Light light : kLights) {
    for (const Renderer& renderer : renderers()) {
      whole.light = shuffled.light = split.light = light;
      expect_same(whole, shuffled, renderer, name_of(light) + ", shuffled");
      expect_same(whole, split, renderer, name_of(light) + ", in parts");
    }
  }
  // Methods that don't sample emitters on the mesh are unaffected: each ray hits the same
  // triangle.
  whole.light = shuffled.light = Light::kLamp;
  for (const Renderer& renderer : {renderers()[0], renderers()[1]}) {
    const Renders a = renders_of(whole, renderer, 9, 1), b = renders_of(shuffled, renderer, 9, 1);
    EXPECT_EQ(a.pixels, b.pixels) << renderer.name;
  }
}

}  // namespace
}  // namespace kinome::test::invariance_test
