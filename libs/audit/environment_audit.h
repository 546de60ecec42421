#pragma once

#include "kinome/emitter.h"
#include "kinome/environment_grid.h"
#include "audit/object_audit.h"

/// The part of find_contradiction(Emitter) that checks environments.
namespace kinome {

/// Checks a sample with a positive density and a unit direction.
const char* environment_contradiction(const Emitter& emitter, const DirectSample& sample);

/// Checks the emitter's grid and the functions that depend on it.
const char* grid_contradiction(const Emitter& emitter, const EnvironmentGrid& grid,
                               const AuditPlace& place, uint64_t attempt);

}  // namespace kinome
