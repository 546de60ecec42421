#pragma once

#include "kinome/emitter.h"
#include "plugin/object_audit.h"

/// The part of contradiction_of(Emitter) that is about light from infinitely far.
namespace kinome {

/// Of a sample with a density, of a direction of unit length.
const char* environment_contradiction(const Emitter& emitter, const DirectSample& sample);

/// Of emitter.cell_grid().
const char* grid_contradiction(const Emitter& emitter, const EnvironmentGrid& grid,
                               const AuditPlace& place, uint64_t attempt);

}  // namespace kinome
