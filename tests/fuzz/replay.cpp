/// Runs a target on files, and on all files of folders: what libFuzzer found once, without it.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "fuzz.h"

namespace {

int replay(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file && bytes.empty()) {
    std::fprintf(stderr, "'%s' can't be read\n", path.c_str());
    return 1;
  }
  std::printf("%s\n", path.c_str());
  std::fflush(stdout);  // what a crash is to blame on
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  int count = 0, failed = 0;
  for (int i = 1; i < argc; ++i) {
    if (!std::filesystem::is_directory(argv[i])) {
      failed += replay(argv[i]);
      ++count;
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      failed += replay(entry.path());
      ++count;
    }
  }
  std::printf("%d inputs\n", count);
  return failed > 0 || count == 0 ? 1 : 0;
}
