#pragma once

#include "kit/statistics.h"

/// The statistics of `kinome check`, which the project's own tests use, too.
namespace kinome::test {
using namespace check;
}  // namespace kinome::test
