#pragma once

#include "check/subject.h"

namespace kinome::check {

/// Of an emitter: the light that leaves it, along rays and as light points.
void add_emission_checks(const Subject& subject, Plan& plan);
/// Light that arrives at a receiver, by rays and as points see it.
void add_irradiance_checks(const Subject& subject, Plan& plan);
/// Its light against that of another emitter, if the request names one.
void add_against_check(const Subject& subject, Plan& plan);
/// Where rays start, and how far away sampled light is.
void add_origin_checks(const Subject& subject, Plan& plan);

}  // namespace kinome::check
