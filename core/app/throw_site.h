#pragma once

#include <string>

namespace kinome::app {

/// From here on it is noted where exceptions are thrown.
void watch_throws();
/// "category/name" of the plugin whose code threw the exception object at this address, itself or
/// by what it called; "" where none did, or long ago. nullptr: the last exception of all.
std::string plugin_that_threw(const void* exception);

}  // namespace kinome::app
