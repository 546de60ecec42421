#pragma once

#include <string>
#include <vector>

#include "kinome/checkpoint.h"
#include "kinome/image.h"
#include "kinome/instruction_set.h"
#include "kinome/render_job.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "options/options.h"

namespace kinome::app {

/// Returns the attributes of an image's header that describe the render.
ImageMetadata metadata_of(const Scene& scene, const RenderJob& job, const std::string& integrator,
                          const RenderStats& stats);

/// Returns the value of --part, "3/16" or "all/16"; "" without --part.
std::string part_text(const Options& options);

/// Returns everything that the bits of the image depend on, except files that the scene names.
Checkpoint::Identity identity_of(const Options& options, const Scene& scene, const Sensor& sensor,
                                 InstructionSet instruction_set);

/// Returns the names of the loaded integrators, separated by spaces. There are several if one (aov)
/// nests others.
std::string integrator_names(const std::vector<std::string>& plugins);

}  // namespace kinome::app
