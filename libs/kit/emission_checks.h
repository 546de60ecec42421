#pragma once

#include "kit/subject.h"

namespace kinome::check {

/// Adds checks of the light that leaves an emitter, along rays and as light points.
void add_emission_checks(const Subject& subject, Plan& plan);
/// Adds a check that compares the light at a receiver by sample_emission() and by sample_direct().
void add_irradiance_checks(const Subject& subject, Plan& plan);
/// Adds a comparison with the light of another emitter, if the request names one.
void add_against_check(const Subject& subject, Plan& plan);
/// Adds checks of the origins of emitted rays and of the distances of sampled light.
void add_origin_checks(const Subject& subject, Plan& plan);

}  // namespace kinome::check
