#pragma once

namespace kinome::app {

/// Opens an optional library of Kinome, as dlopen() does. Looks beside the core's library first,
/// because dlopen() in a build with a sanitizer doesn't search the program's RUNPATH. Then leaves
/// the search to dlopen().
void* open_own_library(const char* name, int mode);

}  // namespace kinome::app
