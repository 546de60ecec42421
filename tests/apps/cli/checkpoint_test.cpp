// Tests of --checkpoint and --resume: any interruption loses little, and the final image is
// byte-identical to that of an uninterrupted render.

#include <sys/stat.h>

#include <cstdlib>
#include <random>

#include "background.h"
#include "cli.h"

namespace kinome::test::checkpoint_test {
namespace {

class CheckpointTest : public Cli {
 protected:
  CheckpointTest()
      : scene_(folder_.write("scene.xml", small_scene())),
        image_(folder_.path("a.exr")),
        checkpoint_(folder_.path("a.checkpoint")) {}

  std::vector<std::string> arguments(const std::vector<std::string>& more) const {
    std::vector<std::string> all = {scene_, "-o", image_, "--checkpoint", checkpoint_};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// Returns the file of a run without checkpoints.
  std::string expected(const std::vector<std::string>& more) const {
    const std::string image = folder_.path("expected.exr");
    std::vector<std::string> all = {"-q", scene_, "-o", image};
    all.insert(all.end(), more.begin(), more.end());
    EXPECT_EQ(kinome(all).status, 0);
    std::string bytes = read_text(image);
    std::filesystem::remove(image);
    return bytes;
  }
  /// Waits for the first checkpoint.
  ::testing::AssertionResult begins() const {
    for (int i = 0; i < 6000; ++i) {
      if (std::filesystem::exists(checkpoint_)) return ::testing::AssertionSuccess();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return ::testing::AssertionFailure() << "no checkpoint is ever written";
  }
  /// Returns the seconds since the checkpoint was written, or nullopt.
  std::optional<double> age() const {
    struct stat info {};
    if (stat(checkpoint_.c_str(), &info) != 0) return std::nullopt;
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    return static_cast<double>(now.tv_sec - info.st_mtim.tv_sec) +
           1e-9 * static_cast<double>(now.tv_nsec - info.st_mtim.tv_nsec);
  }

  std::string scene_, image_, checkpoint_;
};

/// Missing pixels are filled in for the image, but not for the checkpoint.
TEST_F(CheckpointTest, SigtermAndResume) {
  for (const std::string integrator : {"direct", "clustered"}) {
    SCOPED_TRACE(integrator);
    const std::vector<std::string> render = {"-D",     "width=256", "-D",
                                             "spp=64", "-D",        "integrator=" + integrator};
    const std::string log = folder_.path("log");
    std::vector<std::string> first = arguments(render);
    first.insert(first.end(), {"-t", "2", "--every", "0"});
    Background program(first, log);
    ASSERT_TRUE(begins());
    program.send(SIGTERM);
    EXPECT_EQ(program.wait(), 128 + SIGTERM) << program.log();
    EXPECT_NE(program.log().find("--resume continues from " + checkpoint_), std::string::npos);
    // On a busy machine, the signal may come before the first pixel is rendered.
    EXPECT_TRUE(program.log().find(" % of the pixels with one sample") != std::string::npos ||
                program.log().find("100 % of the pixels missing") != std::string::npos)
        << program.log();
    ASSERT_TRUE(std::filesystem::exists(checkpoint_));

    const ProcessResult refused = kinome(first);
    expect_one_error(refused, "", {checkpoint_, "it exists", "--resume"});

    std::vector<std::string> second = arguments(render);
    second.insert(second.end(), {"-t", "1", "--resume"});
    const ProcessResult result = kinome(second);
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("resuming from " + checkpoint_), std::string::npos) << result.err;
    EXPECT_EQ(read_text(image_), expected(render));
    EXPECT_EQ(other_files({scene_, log, image_}), std::vector<std::string>{});
  }
}

/// Kills renders at random moments until they finish: a few times, or KINOME_KILLS times. Each kill
/// loses at most the interval and steps that are shorter than it.
TEST_F(CheckpointTest, KilledAgainAndAgain) {
  const char* const wanted = std::getenv("KINOME_KILLS");
  const int kills = wanted ? std::atoi(wanted) : 6;
  std::mt19937 random(7);
  const std::string log = folder_.path("log");
  int done = 0, resumed = 0, pictures = 0;
  for (; done < kills; ++pictures) {
    const std::vector<std::string> render = {
        "-D",     "width=192",
        "-D",     "spp=32",
        "-D",     std::string("integrator=") + (pictures % 2 == 0 ? "clustered" : "path"),
        "--seed", std::to_string(pictures)};
    const auto start = Clock::now();
    const std::string bytes = expected(render);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    for (bool finished = false; !finished;) {
      std::vector<std::string> run = arguments(render);
      run.insert(run.end(),
                 {"--resume", "--every", "0.01", "-t", std::to_string(1 + random() % 3)});
      Background program(run, log);
      if (done < kills) {
        const double moment = 1.2 * seconds * static_cast<double>(random() % 1000) / 1000;
        std::this_thread::sleep_for(std::chrono::duration<double>(moment));
        program.send(SIGKILL);
      }
      const int status = program.wait();
      finished = status == 0;  // the render finished first
      done += finished ? 0 : 1;
      EXPECT_TRUE(finished || status == 128 + SIGKILL) << status << program.log();
      resumed += program.log().find("resuming") != std::string::npos ? 1 : 0;
    }
    EXPECT_EQ(read_text(image_), bytes) << "image " << pictures << " after " << done << " kills";
    EXPECT_FALSE(std::filesystem::exists(checkpoint_));
    // Few partial files remain, on file systems without O_TMPFILE.
    EXPECT_LE(other_files({scene_, log, image_}).size(), 1u + static_cast<size_t>(done) / 4);
  }
  EXPECT_GT(resumed, kills / 4);
  std::printf("%d images, %d kills, %d resumed renders\n", pictures, done, resumed);
}

/// The checkpoint of a long render is never older than its interval.
TEST_F(CheckpointTest, IsWrittenOften) {
  const std::string log = folder_.path("log");
  Background program(arguments({"-D", "width=256", "-D", "spp=100000", "--every", "0.1"}), log);
  ASSERT_TRUE(begins());
  for (int i = 0; i < 10; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const auto seconds = age();
    ASSERT_TRUE(seconds);
    // A tile takes at most 0.1 s; the rest is tolerance for a busy machine.
    EXPECT_LT(*seconds, 3);
  }
}

TEST_F(CheckpointTest, ForeignOnesAreRefused) {
  const std::string log = folder_.path("log");
  {
    Background program(arguments({"-D", "width=256", "-D", "spp=100000", "--every", "0"}), log);
    ASSERT_TRUE(begins());
    program.send(SIGKILL);
    program.wait();
  }
  const std::vector<std::string> same = {"--resume", "-D", "width=256", "-D", "spp=100000"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), same.begin(), same.end());
    return kinome(arguments(more));
  };
  const std::string whose = "checkpoint '" + checkpoint_ + "': it belongs to another render: its ";
  expect_one_error(with({"--seed", "1"}), "", {whose + "seed is '0', expected '1'"});
  expect_one_error(with({"-s", "above"}), "", {whose});
  const std::string whose_size = whose + "image size is '256x256', expected '9x9";
  expect_one_error(with({"--crop", "0,0,9,9"}), "", {whose_size + "'"});
  expect_one_error(with({"--crop", "3,4,9,9"}), "", {whose_size + " at 3,4'"});
  expect_one_error(with({"-D", "integrator=path"}), "",
                   {whose + "scene has changed, in the scene files"});
  expect_one_error(with({"--variance"}), "", {whose + "--variance"});
  expect_one_error(with({"--error", "0.5"}), "", {whose + "--error"});
  const auto built = PluginRegistry({KINOME_TEST_PLUGINS}).instruction_sets(Category::kBsdf, "diffuse");
  const std::string lowest = to_string(min_instruction_set());
  if (built.size() > 1 && built[1] <= processor_instruction_set()) {
    expect_one_error(with({"--isa", lowest}), "",
                     {whose + "--isa is '", "', expected '" + lowest + "'"});
  }
  std::string bytes = read_text(checkpoint_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  folder_.write("a.checkpoint", bytes);
  expect_one_error(kinome(arguments(same)), "", {checkpoint_, "damaged", "checksum"});
  folder_.write("a.checkpoint", "the only copy of something else");
  expect_one_error(kinome(arguments(same)), "", {checkpoint_, "not a checkpoint"});
  EXPECT_EQ(read_text(checkpoint_), "the only copy of something else");
  EXPECT_FALSE(std::filesystem::exists(image_));
}

/// An image under the checkpoint's name would be deleted with the checkpoint.
TEST_F(CheckpointTest, MustDifferFromTheOutputFile) {
  namespace fs = std::filesystem;
  const fs::path folder = folder_.folder();
  fs::create_directory(folder / "sub");
  fs::create_directory_symlink(folder, folder / "sub/back");
  fs::create_symlink("a.exr", folder / "link");
  const auto refused = [&](const std::string& checkpoint, const std::string& output) {
    SCOPED_TRACE(checkpoint + ", " + output);
    expect_one_error(kinome({"-q", scene_, "-o", output, "--png", "--checkpoint", checkpoint}), "",
                     {"--checkpoint " + checkpoint + ": must differ from the output file"});
  };
  // The program resolves names relative to this folder.
  const fs::path before = fs::current_path();
  fs::current_path(folder);
  for (const std::string& file : {std::string("a.exr"), std::string("a.png")}) {
    refused(file, "a.exr");
    refused("./" + file, "a.exr");
    refused("sub/../" + file, "a.exr");
    refused("sub/back/" + file, "a.exr");
    refused((folder / file).string(), "a.exr");
    refused(file, "./a.exr");
    refused(file, (folder / "sub/back/a.exr").string());
  }
  refused("link", "a.exr");
  const ProcessResult other =
      kinome({"-q", scene_, "-o", "sub/a.exr", "--checkpoint", "a.exr"});  // in another folder
  fs::current_path(before);
  EXPECT_EQ(other.status, 0) << other.err;
  EXPECT_TRUE(fs::exists(folder / "sub/a.exr"));
  EXPECT_FALSE(fs::exists(image_));
}

TEST_F(CheckpointTest, OptionsThatMakeNoSense) {
  const auto fails = [&](const std::vector<std::string>& options, const std::string& part) {
    std::vector<std::string> all = {scene_};
    all.insert(all.end(), options.begin(), options.end());
    expect_one_error(kinome(all), "", {part});
  };
  fails({"--resume"}, "--resume: needs --checkpoint");
  fails({"--every", "3"}, "--every: needs --checkpoint");
  fails({"--checkpoint", ""}, "--checkpoint: needs the name");
  fails({"--checkpoint", checkpoint_, "--every", "-1"}, "--every");
  fails({"--checkpoint", checkpoint_, "--every", "nan"}, "--every");
  fails({"--checkpoint", checkpoint_, "--time", "1"}, "--time");
  fails({"--checkpoint", checkpoint_, "--inspect", "1,1"}, "--inspect");
  fails({"--checkpoint", folder_.path("no/c")}, "does not exist");
  fails({"--checkpoint", "/proc/c"}, "cannot write");
  fails({"--checkpoint", image_, "-o", image_}, "must differ from the output file");
  fails({"--checkpoint", folder_.path("a.png"), "-o", image_, "--png"},
        "must differ from the output file");
  fails({"--checkpoint", scene_}, "it exists");
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
}

}  // namespace
}  // namespace kinome::test::checkpoint_test
