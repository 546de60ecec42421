/// Runs a target on files, and on all files of folders: repeats inputs of libFuzzer without it.
///
/// An Error is no failure for most inputs. But if a target refused all inputs (for example because
/// a format's version changed, or a plugin is missing), neither the replay nor the fuzzer would
/// test more than the first checks. Therefore each folder must contain at least one accepted input,
/// and all inputs whose names begin with "good" must be accepted.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "fuzz.h"

namespace {

namespace fs = std::filesystem;

struct Tally {
  int inputs = 0, accepted = 0, failed = 0;
};

void replay(const fs::path& path, Tally& tally) {
  ++tally.inputs;
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file && bytes.empty()) {
    std::fprintf(stderr, "'%s' can't be read\n", path.c_str());
    ++tally.failed;
    return;
  }
  std::printf("%s: ", path.c_str());
  std::fflush(stdout);  // shows which input caused a crash
  kinome::fuzz::refusal.clear();
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  const std::string& refusal = kinome::fuzz::refusal;
  if (refusal.empty()) {
    ++tally.accepted;
    std::printf("accepted\n");
  } else if (path.filename().string().starts_with("good")) {
    ++tally.failed;
    std::printf("must be accepted, but: %s\n", refusal.c_str());
  } else {
    std::printf("refused: %s\n", refusal.c_str());
  }
}

}  // namespace

int main(int argc, char** argv) {
  Tally all;
  for (int i = 1; i < argc; ++i) {
    if (!fs::is_directory(argv[i])) {
      replay(argv[i], all);
      continue;
    }
    std::vector<fs::path> paths;
    for (const auto& entry : fs::directory_iterator(argv[i])) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    const int accepted_before = all.accepted;
    for (const fs::path& path : paths) replay(path, all);
    if (all.accepted == accepted_before) {
      ++all.failed;
      std::printf("%s: no input is accepted, so that only the first checks are tested\n", argv[i]);
    }
  }
  std::printf("%d inputs, %d accepted, %d failed\n", all.inputs, all.accepted, all.failed);
  return all.failed > 0 || all.inputs == 0 ? 1 : 0;
}
