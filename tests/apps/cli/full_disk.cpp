// Preloaded library that simulates a full disk. KINOME_TEST_DISK bytes can be written to files by
// fwrite; after that, writes fail with ENOSPC.
#include <dlfcn.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>

extern "C" size_t fwrite(const void* bytes, size_t size, size_t count, std::FILE* file) {
  using Write = size_t (*)(const void*, size_t, size_t, std::FILE*);
  static const auto next = reinterpret_cast<Write>(dlsym(RTLD_NEXT, "fwrite"));
  static size_t used = 0;
  const char* const room = std::getenv("KINOME_TEST_DISK");
  if (room && fileno(file) > 2) {
    if (used + size * count > std::strtoul(room, nullptr, 10)) {
      errno = ENOSPC;
      return 0;
    }
    used += size * count;
  }
  return next(bytes, size, count, file);
}
