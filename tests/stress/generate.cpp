#include "generate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>

#include <fmt/format.h>

#include "dice.h"
#include "kinome/output_files.h"
#include "kinome/image_files.h"
#include "kinome/image.h"
#include "node_values.h"
#include "spoil.h"

namespace kinome::test {
namespace {

class Generator {
 public:
  Generator(uint64_t seed, uint64_t index, std::string folder)
      : dice_(seed, index), folder_(std::move(folder)) {}

  RandomScene make() {
    if (dice_.chance(0.2)) scale_ = dice_.decades(-6, 6);
    if (dice_.chance(0.15)) {
      offset_ = dice_.direction() * static_cast<float>(scale_ * dice_.decades(0, 4));
    }
    if (dice_.chance(0.15) && scale_ == 1) power_ = dice_.decades(-25, 25);
    RandomScene scene;
    scene.root = {"scene", {{"version", "3.0.0"}}, {}};
    auto& children = scene.root.children;
    children.push_back(sensor());
    const int shapes = 1 + dice_.below(5);
    if (dice_.chance(0.6)) children.push_back(floor());
    for (int i = 0; i < shapes; ++i) children.push_back(shape());
    const int lights = dice_.chance(0.05) ? 0 : 1 + dice_.below(3);
    for (int i = 0; i < lights; ++i) {
      // Half of all scenes have light from infinitely far.
      if (i == 0 && dice_.chance(0.5)) {
        children.push_back(environment());
        if (dice_.chance(0.6)) break;
      } else {
        children.push_back(lamp());
      }
    }
    if (dice_.chance(0.15)) {
      scene.is_valid = false;
      for (int i = 1 + dice_.below(2); i > 0; --i) spoil(scene.root, dice_);
    }
    return scene;
  }

 private:
  SceneNode transform(const std::string& name, std::vector<SceneNode> operations) {
    return {"transform", {{"name", name}}, std::move(operations)};
  }
  SceneNode scaling(const Vec3& by) { return {"scale", {{"value", digits(by)}}}; }
  SceneNode translation(const Vec3& by) { return {"translate", {{"value", digits(by)}}}; }
  SceneNode rotation() {
    const Vec3 axis = dice_.direction();
    return {"rotate",
            {{"x", digits(axis.x)},
             {"y", digits(axis.y)},
             {"z", digits(axis.z)},
             {"angle", digits(dice_.between(-180, 180))}}};
  }
  SceneNode lookat(const Vec3& origin, const Vec3& target, const Vec3& up) {
    return {"lookat", {{"origin", digits(origin)}, {"target", digits(target)}, {"up", digits(up)}}};
  }
  /// Transforms a point from units of the generator to the scene's units.
  Vec3 world(const Vec3& p) { return p * static_cast<float>(scale_) + offset_; }

  SceneNode sensor() {
    const Vec3 from = dice_.direction() * dice_.between(2, 5);
    const Vec3 eye = world(Vec3(from.x, from.y, std::abs(from.z)));
    const Vec3 target = world(dice_.in_cube(0.3f));
    const std::string type = dice_.of<std::string>(
        {"perspective", "perspective", "perspective", "orthographic", "thinlens"});
    std::vector<SceneNode> operations;
    if (type == "orthographic") {
      const double half = scale_ * dice_.decades(-1, 0.5);
      operations.push_back(scaling(Vec3(Vec2(static_cast<float>(half)), 1)));
    }
    operations.push_back(lookat(eye, target, glm::normalize(Vec3(0, 0, 1) + dice_.in_cube(0.1f))));
    std::vector<SceneNode> children{transform("to_world", operations)};
    if (type != "orthographic") {
      children.push_back(number(
          "fov", dice_.chance(0.05) ? dice_.of<double>({0.01, 1, 120}) : dice_.between(20, 80)));
    }
    if (type == "thinlens") {
      children.push_back(number("aperture_radius", scale_ * dice_.decades(-4, 0)));
      children.push_back(number("focus_distance", scale_ * dice_.decades(-0.5, 1)));
    }
    children.push_back(number("near_clip", 1e-3 * scale_));
    children.push_back(number("far_clip", 1e6 * scale_));
    children.push_back(object("sampler", "independent", {integer("sample_count", 1)}));
    std::vector<SceneNode> film{integer("width", 4 + dice_.below(12)),
                                integer("height", 4 + dice_.below(12)),
                                {"rfilter", {{"type", "box"}}}};
    children.push_back(object("film", "hdrfilm", film));
    return object("sensor", type, children);
  }

  Vec3 colour() {
    if (dice_.chance(0.1)) return Vec3(dice_.of<float>({0, 1, 1e-6f}));
    const float r = dice_.unit(), g = dice_.unit();
    return {r, g, dice_.unit()};
  }
  SceneNode reflectance(const std::string& name) {
    if (dice_.chance(0.15)) {
      return named(
          object("texture", "checkerboard",
                 {rgb("color0", colour()), rgb("color1", colour()),
                  transform("to_uv", {scaling(Vec3(static_cast<float>(dice_.decades(-1, 2))))})}),
          name);
    }
    if (dice_.chance(0.05)) {
      return named(object("texture", "bitmap",
                          {text("filename", image(1 + dice_.below(4), 1 + dice_.below(4), 1)),
                           boolean("raw", true)}),
                   name);
    }
    return rgb(name, colour());
  }
  double roughness() {
    return dice_.chance(0.15) ? dice_.of<double>({0, 1e-9, 1e-5, 1e-3, 1, 3})
                              : dice_.decades(-1.5, 0);
  }
  void add_roughness(std::vector<SceneNode>& children) {
    if (dice_.chance(0.3)) {
      children.push_back(number("alpha_u", roughness()));
      children.push_back(number("alpha_v", roughness()));
    } else {
      children.push_back(number("alpha", roughness()));
    }
  }
  void add_distribution(std::vector<SceneNode>& children) {
    if (dice_.chance(0.5)) children.push_back(text("distribution", "ggx"));
    if (dice_.chance(0.2)) children.push_back(boolean("sample_visible", false));
  }

  SceneNode plain_bsdf() {
    std::vector<SceneNode> c;
    switch (dice_.below(10)) {
      case 0:
      case 1:
      case 2:
        return object("bsdf", "diffuse", {reflectance("reflectance")});
      case 3:
        c = {number("exponent", dice_.chance(0.2) ? dice_.of<double>({0, 0.1, 1e4, 1e6})
                                                  : dice_.decades(0, 2.5)),
             reflectance("diffuse_reflectance"), reflectance("specular_reflectance")};
        return object("bsdf", "phong", c);
      case 4:
        c = {text("variant", dice_.of<std::string>({"balanced", "ward", "ward-duer"})),
             reflectance("diffuse_reflectance"), reflectance("specular_reflectance")};
        add_roughness(c);
        return object("bsdf", "ward", c);
      case 5:
      case 6:
        add_distribution(c);
        add_roughness(c);
        if (dice_.chance(0.5)) {
          c.push_back(text("material", dice_.of<std::string>({"Au", "Al", "Cu", "W"})));
        } else if (dice_.chance(0.3)) {
          c.push_back(number("eta", dice_.between(0.1f, 3)));
          c.push_back(number("k", dice_.between(0, 5)));
        }
        return object("bsdf", "roughconductor", c);
      case 7:
      case 8:
        add_distribution(c);
        c.push_back(number("alpha", roughness()));
        c.push_back(reflectance("diffuse_reflectance"));
        c.push_back(boolean("nonlinear", dice_.chance(0.5)));
        if (dice_.chance(0.3)) c.push_back(number("int_ior", dice_.between(1, 2.5f)));
        return object("bsdf", "roughplastic", c);
      default:
        return dice_.chance(0.5) ? object("bsdf", "conductor")
                                 : object("bsdf", "plastic", {reflectance("diffuse_reflectance")});
    }
  }
  SceneNode bsdf() {
    SceneNode node = plain_bsdf();
    if (dice_.chance(0.12)) {
      node =
          object("bsdf", "normalmap",
                 {named(object("texture", "bitmap",
                               {text("filename", image(1 + dice_.below(5), 1 + dice_.below(5), 1)),
                                boolean("raw", true)}),
                        "normalmap"),
                  node});
    }
    if (dice_.chance(0.25)) node = object("bsdf", "twosided", {node});
    return node;
  }

  /// Returns the transform of a shape of unit size.
  SceneNode placement() {
    Vec3 size(static_cast<float>(dice_.decades(-1.3f, 0.2f)));
    if (dice_.chance(0.3))
      size *= glm::mix(Vec3(0.2f), Vec3(1.f), Vec3(dice_.unit(), dice_.unit(), dice_.unit()));
    if (dice_.chance(0.05)) size[dice_.below(3)] *= static_cast<float>(dice_.decades(-7, -2));
    if (dice_.chance(0.05)) size *= static_cast<float>(dice_.decades(-4, 3));
    if (dice_.chance(0.1)) size[dice_.below(3)] *= -1;
    return transform("to_world", {scaling(size), rotation(), translation(dice_.in_cube(0.8f)),
                                  scaling(Vec3(static_cast<float>(scale_))), translation(offset_)});
  }

  SceneNode shape() {
    const std::string type =
        dice_.of<std::string>({"sphere", "cube", "rectangle", "disk", "cylinder", "obj", "obj"});
    std::vector<SceneNode> c{placement()};
    // A sphere or cylinder needs a uniform scale to keep its form.
    if (type == "sphere" || type == "cylinder") {
      c[0].children[0] = scaling(Vec3(static_cast<float>(dice_.decades(-1.5f, 0.1f))));
    }
    if (type == "obj") {
      c.push_back(text("filename", mesh()));
      if (dice_.chance(0.2)) c.push_back(boolean("face_normals", true));
    }
    if (dice_.chance(0.15)) c.push_back(boolean("flip_normals", true));
    c.push_back(bsdf());
    if (dice_.chance(0.15)) {
      c.push_back(object("emitter", "area", {rgb("radiance", light(10))}));
    }
    return object("shape", type, c);
  }

  /// The floor is not larger, because light is rare for most methods if one shape is vast compared
  /// with the rest.
  SceneNode floor() {
    SceneNode place =
        transform("to_world", {scaling(Vec3(static_cast<float>(dice_.decades(0.2f, 0.9f)))),
                               translation({0, 0, -0.8f}),
                               scaling(Vec3(static_cast<float>(scale_))), translation(offset_)});
    return object("shape", "rectangle", {place, bsdf()});
  }

  Vec3 light(double strength) {
    const float s = static_cast<float>(power_ * strength * dice_.decades(-1, 1));
    const float r = dice_.unit(), g = dice_.unit();
    return s * Vec3(r, g, dice_.unit());
  }

  SceneNode environment() {
    if (dice_.chance(0.35)) return object("emitter", "constant", {rgb("radiance", light(1))});
    int width = 1 + dice_.below(32), height = 1 + dice_.below(17);
    if (dice_.chance(0.01)) width = 2048, height = 1024;
    if (dice_.chance(0.002)) width = 4096, height = 2048;
    std::vector<SceneNode> c{text("filename", image(width, height, power_)),
                             transform("to_world", {rotation()})};
    if (dice_.chance(0.3)) c.push_back(boolean("mis_compensation", true));
    return object("emitter", "envmap", c);
  }

  SceneNode lamp() {
    const Vec3 at = dice_.direction() * dice_.between(0.5f, 3);
    const Vec3 place = world(Vec3(at.x, at.y, std::abs(at.z)));
    const Vec3 target = world(dice_.in_cube(0.5f));
    // Intensities grow with the square of lengths, so that the scene is neither too dark nor too
    // bright.
    const auto intensity = [&] { return light(5) * static_cast<float>(scale_ * scale_); };
    switch (dice_.below(4)) {
      case 0:
        return object(
            "emitter", "point",
            {value_of("point", "position", digits(place)), rgb("intensity", intensity())});
      case 1: {
        const double cutoff =
            dice_.chance(0.2) ? dice_.of<double>({90, 180, 1, 1e-3}) : dice_.between(10, 80);
        return object("emitter", "spot",
                      {transform("to_world", {lookat(place, target, {0.1f, 1, 0})}),
                       rgb("intensity", intensity()), number("cutoff_angle", cutoff),
                       number("beam_width", cutoff * dice_.of<double>({0, 0.5, 1}))});
      }
      case 2:
        return object(
            "emitter", "directional",
            {value_of("vector", "direction", digits(target - place)), rgb("irradiance", light(2))});
      default:
        return object("emitter", "projector",
                      {transform("to_world", {lookat(place, target, {0.1f, 1, 0})}),
                       number("fov", dice_.between(5, 120)),
                       number("scale", power_ * scale_ * scale_ * dice_.decades(0, 1))});
    }
  }

  /// Values of 0 to `scale`. One may be far larger if `scale` is not 1.
  std::string image(int width, int height, double scale) {
    Image image{width, height, {"R", "G", "B"}, {}};
    const int kind = dice_.below(4);
    const size_t size = static_cast<size_t>(width) * height;
    image.data.reserve(3 * size);
    const size_t sun = dice_.bits() % size;
    const bool is_light = width > 5 || scale != 1 || kind == 3;
    for (size_t i = 0; i < size; ++i) {
      const float shade = kind == 0 ? 1.f : kind == 1 && i % 3 ? 0.f : dice_.unit();
      const float peak = is_light && kind >= 2 && i == sun ? 300.f : 1.f;
      for (int c = 0; c < 3; ++c) {
        image.data.push_back(static_cast<float>(scale) * shade *
                             (0.3f + 0.2f * static_cast<float>(c)) *
                             (scale == 1 && width < 6 ? 1.f : peak));
      }
    }
    const std::string name = fmt::format("image{}.pfm", files_++);
    write_pfm(folder_ + "/" + name, image);
    return name;
  }

  /// Random triangles or a bent grid, some with degenerate faces.
  std::string mesh() {
    std::string out;
    const int side = 2 + dice_.below(5);
    const bool is_grid = dice_.chance(0.5), has_normals = dice_.chance(0.5);
    const float bend = dice_.chance(0.3) ? 1.5f : 0.3f;
    const int count = side * side;
    for (int i = 0; i < count; ++i) {
      const auto x = static_cast<float>(i % side), y = static_cast<float>(i / side);
      const auto last = static_cast<float>(side - 1);
      const Vec3 p = is_grid ? Vec3(2 * x / last - 1, 2 * y / last - 1, 0.3f * dice_.unit())
                             : dice_.in_cube(1);
      out += "v " + digits(p) + "\n";
      if (has_normals) {
        out += "vn " + digits(glm::normalize(Vec3(0, 0, 1) + bend * dice_.in_cube(0.5f))) + "\n";
      }
    }
    const auto face = [&](int a, int b, int c) {
      out += has_normals ? fmt::format("f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1, c + 1)
                         : fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
    };
    if (is_grid) {
      for (int y = 0; y + 1 < side; ++y) {
        for (int x = 0; x + 1 < side; ++x) {
          const int a = y * side + x;
          face(a, a + 1, a + side + 1);
          face(a, a + side + 1, a + side);
        }
      }
    } else {
      // No triangle occurs twice: of two emitting triangles in one position, rays hit one, while
      // light tracing shows both.
      std::set<std::array<int, 3>> made;
      for (int i = 0; i < count; ++i) {
        const std::array<int, 3> corners = {dice_.below(count), dice_.below(count),
                                            dice_.below(count)};
        std::array<int, 3> key = corners;
        std::sort(key.begin(), key.end());
        if (made.insert(key).second) face(corners[0], corners[1], corners[2]);
      }
    }
    if (dice_.chance(0.3)) face(0, 0, 0);
    if (dice_.chance(0.3)) face(0, 1, 1);
    const std::string name = fmt::format("mesh{}.obj", files_++);
    write_text(folder_ + "/" + name, out);
    return name;
  }

  Dice dice_;
  std::string folder_;
  double scale_ = 1;  ///< of all lengths
  Vec3 offset_{0.f};
  double power_ = 1;  ///< of all light
  int files_ = 0;
};

}  // namespace

RandomScene random_scene(uint64_t seed, uint64_t index, const std::string& folder) {
  return Generator(seed, index, folder).make();
}

}  // namespace kinome::test
