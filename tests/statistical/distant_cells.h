#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "clustered/cells/light_cells.h"
#include "envmap_cases.h"
#include "kinome/clustered_light.h"
#include "kinome/warp.h"

/// Skies for tests of DistantCells.
namespace kinome::test::distant_cells {

/// An emitter that implements only the mandatory functions, as a third party's may: a disc far
/// smaller than a quad, on a gradient.
class Disc final : public Emitter, public ClusteredLight {
 public:
  bool is_environment() const override { return true; }
  Rgb eval_environment(const Vec3& d) const override {
    const Vec3 centre = glm::normalize(Vec3(0.4f, 0.7f, -0.5f));
    return glm::dot(d, centre) > std::cos(0.02f) ? Rgb(800, 600, 300)
                                                 : Rgb(0.2f, 0.3f, 0.5f) * (1.2f + d.y);
  }
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2& u) const override {
    DirectSample sample;
    sample.d = square_to_uniform_sphere(u);
    sample.pdf = kUniformSpherePdf;
    sample.radiance = eval_environment(sample.d);
    return sample;
  }
  float pdf_environment(const Vec3&) const override { return kUniformSpherePdf; }
  std::optional<EnvironmentGrid> cell_grid() const override { return EnvironmentGrid{}; }
};

struct Case {
  std::string name;
  std::shared_ptr<Emitter> emitter;
  bool black = false;
};

inline std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Map& map : maps()) all.push_back({map.name, envmap(map)});
  all.push_back({"noise, rotated", envmap(maps()[0], kRotation)});
  all.push_back({"sun at the pole, mirrored",
                 envmap(maps()[1], "<transform name=\"to_world\"><scale x=\"-1\"/></transform>")});
  all.push_back({"constant", make<Emitter>("<emitter type=\"constant\"><rgb name=\"radiance\" "
                                           "value=\"1 .5 .25\"/></emitter>")});
  all.push_back({"disc", std::make_shared<Disc>()});
  all.push_back({"sunsky", make<Emitter>("<emitter type=\"sunsky\"><vector name=\"sun_direction\" "
                                         "value=\"1 1 1\"/><float name=\"sun_aperture\" "
                                         "value=\"30\"/></emitter>")});
  return all;
}

inline const Scheduler& scheduler() {
  static const RenderContext instance({.threads = 2});
  return instance.scheduler;
}
inline DistantCells make_cells(const Emitter& emitter, uint32_t count) {
  return {emitter, cell_grid_of(emitter).value(), count, scheduler()};
}

/// Directions and the results of look_up() for them.
struct Found {
  std::vector<float> x, y, z, density;
  std::vector<uint32_t> cell;
  std::vector<Rgb> radiance;
  void add(const Vec3& d) {
    x.push_back(d.x);
    y.push_back(d.y);
    z.push_back(d.z);
  }
  Vec3 direction(size_t i) const { return {x[i], y[i], z[i]}; }
  void look_up(const DistantCells& cells) {
    const size_t count = x.size();
    while (x.size() % DistantCells::kPadding != 0) add(Vec3(0, 1, 0));
    density.resize(x.size());
    cell.resize(x.size());
    radiance.resize(x.size());
    cells.look_up({x.data(), y.data(), z.data(), cell.data(), density.data(), radiance.data()},
                  count);
    x.resize(count);
  }
};

}  // namespace kinome::test::distant_cells
