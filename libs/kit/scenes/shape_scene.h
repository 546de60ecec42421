#pragma once

#include <memory>
#include <vector>

#include "kinome/shape.h"
#include "kinome/warp.h"
#include "kit/scenes/rays.h"
#include "kit/statistics/random.h"
#include "kit/subject.h"

namespace kinome::check {

/// Scene with only the checked shape, or with its parts.
struct ShapeScene {
  explicit ShapeScene(const Subject& subject) : scene(subject.scene(subject.xml())) {
    centre = scene->bounds().centre();
    radius = 0.505f * glm::length(scene->bounds().extent());
  }
  bool is_empty() const { return scene->shapes().empty() || scene->bounds().empty(); }
  const std::vector<std::shared_ptr<Shape>>& shapes() const { return scene->shapes(); }

  /// Returns a random line through the sphere around the shape, uniformly distributed.
  Ray line(Random& random) const {
    const Vec3 d = random.direction();
    const Frame frame = Frame::from_normal(d);
    const Vec2 across = radius * square_to_disk_concentric(random.unit2());
    Ray ray;
    ray.d = d;
    ray.o = centre + frame.s * across.x + frame.t * across.y - 1.5f * radius * d;
    return ray;
  }
  /// Calls use(hit, interaction) for each hit along a line. Returns the number of hits.
  template <class Use>
  int crossings(const Ray& line, const Use& use) const {
    constexpr int kMaxHits = 200;
    return for_each_hit(*scene, line.o, line.d, kMaxHits, use);
  }

  std::unique_ptr<Scene> scene;
  Vec3 centre{0.f};
  float radius = 1;
};

/// Checks of block functions.
Outcome shape_blocks(const Subject& subject);
Outcome shape_sample_blocks(const Subject& subject);

}  // namespace kinome::check
