#pragma once

#include <cstddef>

namespace kinome::test {

/// Returns the largest single allocation of the process, plugins included, since the last reset. A
/// broken file must not make a reader request gigabytes, even if it never touches them.
size_t largest_allocation();
void reset_largest_allocation();

}  // namespace kinome::test
