#pragma once

#include "dice.h"
#include "scene_node.h"

namespace kinome::test {

/// Makes a random node invalid, or extreme enough that it may be.
void spoil(SceneNode& root, Dice& dice);

}  // namespace kinome::test
