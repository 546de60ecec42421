#pragma once

#include "check/statistics.h"

/// The statistics of `kinome check`, by which the project's own tests are made, too.
namespace kinome::test {
using namespace check;
}  // namespace kinome::test
