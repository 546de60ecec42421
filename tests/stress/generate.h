#pragma once

#include <cstdint>
#include <string>

#include "scene_node.h"

/// Random scenes.
namespace kinome::test {

struct RandomScene {
  SceneNode root;  ///< sensor, shapes, lights; no integrator
  /// False where something was made wrong on purpose: then an error is as good as a picture.
  bool is_valid = true;
};

/// Scene number `index` of the run `seed`: the same wherever it is asked for. Writes the meshes and
/// images that it refers to, by name alone, into `folder`. All of it is legal unless is_valid is
/// false: any shape, material and light, degenerate triangles, parameters at their extremes, scenes
/// of 1e-6 to 1e6, light of 1e-25 to 1e25.
RandomScene random_scene(uint64_t seed, uint64_t index, const std::string& folder);

}  // namespace kinome::test
