#pragma once

#include <cstddef>

namespace kinome::test {

/// The largest single allocation since the last reset, of the whole process with its plugins: a
/// broken file must not make a reader ask for gigabytes, whether or not it ever touches them.
size_t largest_allocation();
void reset_largest_allocation();

}  // namespace kinome::test
