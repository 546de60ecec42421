#pragma once

#include "check/subject.h"

namespace kinome::check {

/// Of an emitter: the light that leaves it, along rays and as light points.
void add_emission_checks(const Subject& subject, Plan& plan);

}  // namespace kinome::check
