#include "kinome/read_files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <string>

#include "kinome/error.h"
#include "support/render.h"

namespace kinome::test::read_files_test {
namespace {

/// Sets a limit of this process during its lifetime.
class Limit {
 public:
  Limit(decltype(RLIMIT_AS) resource, rlim_t value) : resource_(resource) {
    getrlimit(resource_, &before_);
    const rlimit limit{value, before_.rlim_max};
    setrlimit(resource_, &limit);
  }
  ~Limit() { setrlimit(resource_, &before_); }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

 private:
  decltype(RLIMIT_AS) resource_;
  rlimit before_{};
};

std::string error_of_reading(const std::string& path) {
  try {
    file_contents(path);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ReadFiles, ErrorsNameTheFileAndTheReason) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.ply", "ply\n"), missing = folder.path("none.ply");
  EXPECT_EQ(file_contents(file), "ply\n");
  EXPECT_EQ(error_of_reading(missing), missing + ": can't be read: No such file or directory");
  EXPECT_EQ(error_of_reading(folder.path(".")),
            folder.path(".") + ": can't be read: Is a directory");
  const Limit limit(RLIMIT_NOFILE, 0);
  EXPECT_EQ(error_of_reading(file), file + ": can't be read: Too many open files");
}

#ifndef KINOME_HAS_SANITIZER  // whose allocators end the process
TEST(ReadFiles, ErrorOfAHugeFileNamesIt) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.ply", "ply\n");
  std::filesystem::resize_file(file, uint64_t{300} << 30);
  const Limit limit(RLIMIT_AS, rlim_t{100} << 30);
  EXPECT_EQ(error_of_reading(file), file + ": doesn't fit in memory (322 GB)");
}
#endif

}  // namespace
}  // namespace kinome::test::read_files_test
