#pragma once

#include <cstdint>
#include <string>

#include "scene_node.h"

/// Random scenes.
namespace kinome::test {

struct RandomScene {
  SceneNode root;  ///< sensor, shapes, emitters; no integrator
  /// False if something was made invalid on purpose: then an error is as correct as an image.
  bool is_valid = true;
};

/// Returns scene number `index` of the run `seed`, which is reproducible. Writes the meshes and
/// images that it refers to by name into `folder`. If is_valid, the whole scene is legal: any
/// shape, material and emitter, degenerate triangles, extreme parameters, scenes of 1e-6 to 1e6
/// units, light of 1e-25 to 1e25.
RandomScene random_scene(uint64_t seed, uint64_t index, const std::string& folder);

}  // namespace kinome::test
