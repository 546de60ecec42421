#pragma once

namespace kinome::app {

/// Opens a library of Kinome that isn't always needed, as dlopen(). It is expected beside the
/// core's library, otherwise where dlopen() finds its name. A name alone isn't enough: with a
/// sanitizer, dlopen() doesn't search the program's RUNPATH.
void* open_own_library(const char* name, int mode);

}  // namespace kinome::app
