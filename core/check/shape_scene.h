#pragma once

#include <memory>
#include <vector>

#include "check/random.h"
#include "check/rays.h"
#include "check/subject.h"
#include "kinome/shape.h"
#include "kinome/warp.h"

namespace kinome::check {

/// The shape, or what a scene has in its place, by itself.
struct ShapeScene {
  explicit ShapeScene(const Subject& subject) : scene(subject.scene(subject.xml())) {
    centre = scene->bounds().centre();
    radius = 0.505f * glm::length(scene->bounds().extent());
  }
  bool is_empty() const { return scene->shapes().empty() || scene->bounds().empty(); }
  const std::vector<std::shared_ptr<Shape>>& shapes() const { return scene->shapes(); }

  /// One of all lines that pass the sphere around the shape.
  Ray line(Random& random) const {
    const Vec3 d = random.direction();
    const Frame frame = Frame::from_normal(d);
    const Vec2 across = radius * square_to_disk_concentric(random.unit2());
    Ray ray;
    ray.d = d;
    ray.o = centre + frame.s * across.x + frame.t * across.y - 1.5f * radius * d;
    return ray;
  }
  /// All that a line meets.
  template <class Use>
  int crossings(const Ray& line, const Use& use) const {
    constexpr int kMost = 200;
    int count = 0;
    Vec3 o = line.o;
    for (; count < kMost; ++count) {
      const RayHit hit = trace(*scene, o, line.d);
      if (!hit.hit.valid()) break;
      const SurfaceInteraction si = scene->interaction(hit);
      use(hit, si);
      o = si.ray_origin(line.d);
    }
    return count;
  }

  std::unique_ptr<Scene> scene;
  Vec3 centre{0.f};
  float radius = 1;
};

/// Of blocks of rays and points.
Outcome shape_blocks(const Subject& subject);
Outcome shape_sample_blocks(const Subject& subject);

}  // namespace kinome::check
