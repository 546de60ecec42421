#pragma once

#include <string>

namespace kinome::app {

/// Starts to record the call stacks of throws.
void watch_throws();
/// Returns "category/name" of the innermost plugin on the call stack when the exception object at
/// this address was thrown. Returns "" if there was no plugin, or if the throw is too long ago.
/// nullptr stands for the last exception.
std::string plugin_that_threw(const void* exception);

}  // namespace kinome::app
