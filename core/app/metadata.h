#pragma once

#include <string>
#include <vector>

#include "kinome/checkpoint.h"
#include "kinome/image.h"
#include "kinome/instruction_set.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "options.h"

namespace kinome::app {

/// What a picture's header says of how it was made.
ImageMetadata metadata_of(const Scene& scene, const RenderContext& context,
                          const std::string& integrator, const RenderStats& stats);

/// "3/16" or "all/16", as --part says; "": it isn't given.
std::string part_text(const Options& options);

/// All that the bits of the picture depend on, but for the files that the scene names.
Checkpoint::Identity identity_of(const Options& options, const Scene& scene, const Sensor& sensor,
                                 InstructionSet instruction_set);

/// Names of the loaded integrators, of which an aov integrator nests others, with spaces between.
std::string integrator_names(const std::vector<std::string>& plugins);

}  // namespace kinome::app
