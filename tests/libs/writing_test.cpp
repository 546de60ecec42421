/// Tests image files that can't be written: full disks, invalid paths, interruptions.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "support/image_helpers.h"
#include "kinome/output_files.h"
#include "kinome/image_files.h"

namespace kinome::test::writing_test {
namespace {

namespace fs = std::filesystem;

/// Simulates a full disk: files of this process can't grow beyond `bytes` until it is destroyed.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &saved_);
    const rlimit limit{bytes, saved_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &saved_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit saved_{};
  void (*handler_)(int);
};

TEST(Writing, FullDiskIsOneErrorAndLeavesTheOldFile) {
  const TemporaryFolder folder;
  // Sizes at which the header, the pixels, or only the last bytes don't fit.
  const Image image = make_image(128, 128, {"R", "G", "B"});
  for (const char* name : {"a.exr", "a.pfm", "a.png"}) {
    const std::string path = folder.path(name);
    const auto write = [&] {
      const std::string_view extension = std::string_view(name).substr(2);
      if (extension == "exr") write_exr(path, image, ExrSampleType::kFloat, {});
      if (extension == "pfm") write_pfm(path, image);
      if (extension == "png") write_png(path, image, 0);
    };
    write();
    const uintmax_t size = fs::file_size(path);
    for (const bool old_file : {true, false}) {
      fs::remove(path);
      if (old_file) folder.write(name, "old");
      for (const uintmax_t limit : {uintmax_t{1}, uintmax_t{5000}, size / 2, size - 1}) {
        const FullDisk full(limit);
        expect_error(write, path, "File too large");
      }
      EXPECT_EQ(read_file(path), old_file ? "old" : "");
      EXPECT_EQ(file_count(folder.folder()), old_file ? 1 : 0) << "a temporary file remains";
    }
    fs::remove(path);
  }
}

TEST(Writing, UnwritableFilesAreReportedBeforeTheRender) {
  const TemporaryFolder folder;
  const Image image = make_image(2, 2, {"Y"});
  const std::string file = folder.write("file", "x");
  fs::create_symlink("loop", folder.path("loop"));
  fs::create_symlink("none/a.exr", folder.path("link"));
  const struct {
    std::string path;
    const char* part;
  } cases[] = {{folder.path("loop"), "symbolic links"},
               {folder.path("loop/a.exr"), "symbolic links"},
               {folder.path("link"), "does not exist"},
               {folder.path(std::string(300, 'x') + "/a.exr"), "too long"},
               {folder.path("none/a.exr"), "does not exist"},
               {folder.folder(), "folder"},
               {folder.path("a/"), "folder"},
               {file + "/a.exr", ""},
               {"/proc/kinome_test.exr", ""},
               {"/dev/full", "not a regular file"}};
  for (const auto& c : cases) {
    expect_error([&] { check_writable(c.path); }, c.path, c.part);
    expect_error([&] { write_exr(c.path, image, ExrSampleType::kHalf, {}); }, c.path, c.part);
  }
  if (geteuid() != 0) {
    fs::create_directory(folder.path("locked"));
    fs::permissions(folder.path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
    const std::string path = folder.path("locked/a.exr");
    expect_error([&] { check_writable(path); }, path, "Permission denied");
    fs::permissions(folder.path("locked"), fs::perms::none);
    expect_error([&] { check_writable(path); }, path, "Permission denied");
    // The folder is writable but not readable: files can be created, but the folder can't be
    // synced.
    fs::permissions(folder.path("locked"), fs::perms::owner_write | fs::perms::owner_exec);
    write_pfm(folder.path("locked/a.pfm"), image);
    sync_file(folder.path("locked/a.pfm"));
  }
  EXPECT_THROW(check_writable(""), Error);
  check_writable(folder.path("a.exr"));
  check_writable(file);
  EXPECT_EQ(read_file(file), "x");
  EXPECT_FALSE(fs::exists(folder.path("a.exr")));
}

TEST(Writing, FollowsLinksAndHonoursTheUmask) {
  const TemporaryFolder folder;
  const Image image = make_image(2, 2, {"Y"});
  folder.write("target.pfm", "old");
  fs::create_symlink("target.pfm", folder.path("link.pfm"));
  write_pfm(folder.path("link.pfm"), image);
  EXPECT_TRUE(fs::is_symlink(folder.path("link.pfm")));
  EXPECT_EQ(read_pfm(folder.path("target.pfm")).data, image.data);
  // The target of a link need not exist.
  fs::create_directory(folder.path("sub"));
  fs::create_symlink("sub/later.pfm", folder.path("first.pfm"));
  fs::create_symlink("first.pfm", folder.path("second.pfm"));
  check_writable(folder.path("second.pfm"));
  write_pfm(folder.path("second.pfm"), image);
  EXPECT_TRUE(fs::is_symlink(folder.path("first.pfm")));
  EXPECT_TRUE(fs::is_symlink(folder.path("second.pfm")));
  EXPECT_EQ(read_pfm(folder.path("sub/later.pfm")).data, image.data);
  const mode_t mask = umask(022);
  write_pfm(folder.path("new.pfm"), image);
  umask(mask);
  EXPECT_EQ(fs::status(folder.path("new.pfm")).permissions() & fs::perms::mask, fs::perms(0644));
}

TEST(Writing, InterruptedWritersAreCleanedUp) {
  const TemporaryFolder folder;
  // The child stops in the middle of a write, as a process does at a second signal.
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, [](int) {
      remove_temporary_files();
      _exit(42);
    });
    const rlimit limit{4096, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &limit);
    write_pfm(folder.path("a.pfm"), make_image(256, 256, {"R", "G", "B"}));
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 42);
  EXPECT_EQ(file_count(folder.folder()), 0);
}

}  // namespace
}  // namespace kinome::test::writing_test
