// Tests of output that can't be written, and of interrupted renders: no partial file remains.

#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "background.h"
#include "cli.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::test {
namespace {

/// Enough tiles that a render takes far more than a second when it first reports progress. After an
/// interruption, the remaining tiles must be filled in within two seconds. Paths take some
/// hundredths of a second for it, ten times as much under ThreadSanitizer, and more on a busy
/// machine.
#if defined(__SANITIZE_THREAD__)
constexpr int kTilesAcross = 8, kSamples = 250, kManySamples = 512, kSamplesOfTenths = 16;
#else
constexpr int kTilesAcross = 16, kSamples = 1000, kManySamples = 65536, kSamplesOfTenths = 256;
#endif
constexpr int kWidth = kTilesAcross * kSmallTileSize;

class Interrupt : public Cli {
 protected:
  Interrupt() : scene_(folder_.write("scene.xml", small_scene())), image_(folder_.path("a.exr")) {}

  /// Sends the first signal: current tiles are finished, and the image is written.
  Image interrupted(int signal, const std::string& integrator, ImageMetadata& metadata) {
    const std::string log = folder_.path("log");
    Background program({scene_, "-o", image_, "-t", "2", "-D", "width=" + std::to_string(kWidth),
                        "-D", "spp=" + std::to_string(kSamples), "-D", "integrator=" + integrator},
                       log);
    EXPECT_TRUE(program.says("rendering: "));
    program.send(signal);
    EXPECT_EQ(program.wait(), 128 + signal) << program.log();
    EXPECT_NE(program.log().find("incomplete, "), std::string::npos) << program.log();
    EXPECT_EQ(other_files({scene_, log}), std::vector<std::string>{image_});
    Image image = read_exr(image_, {}, &metadata);
    EXPECT_EQ(metadata["kinome:complete"], "false");
    return image;
  }
  /// Expects that tiles that weren't started have one sample per pixel, because that is fast.
  /// `done`: minimum number of finished tiles.
  static void expect_filled(const Image& image, ImageMetadata& metadata, int done) {
    EXPECT_EQ(metadata["kinome:missing"], "0");
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    // The scene is lit everywhere: black tiles have not been rendered.
    EXPECT_EQ(dark_tiles(image), 0);
    EXPECT_GT(std::stod(metadata["kinome:filled"]), 0);
    EXPECT_LE(std::stod(metadata["kinome:filled"]), 1 - done / sqr(1. * kTilesAcross));
  }
  /// Expects that alpha is 0 where nothing was rendered, which is part of the image.
  static void expect_marked(const Image& image, ImageMetadata& metadata) {
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
    int missing = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const float alpha = image.at(x, y, 3);
        ASSERT_TRUE(alpha == 1 || (alpha == 0 && image.at(x, y, 1) == 0)) << x << " " << y;
        missing += alpha == 0;
      }
    }
    EXPECT_GT(missing, 0);
    EXPECT_NEAR(std::stod(metadata["kinome:missing"]), missing / (1. * image.width * image.height),
                1e-4);
  }
  void expect_first_signal_writes(int signal, const std::string& integrator = "direct") {
    ImageMetadata metadata;
    const Image image = interrupted(signal, integrator, metadata);
    expect_filled(image, metadata, 1);
  }
  /// Returns the number of tiles without any light. Some single samples find no light.
  static int dark_tiles(const Image& image) {
    int tiles = 0;
    for (int y = 0; y < image.height; y += kSmallTileSize) {
      for (int x = 0; x < image.width; x += kSmallTileSize) {
        float light = 0;
        for (int i = 0; i < kSmallTileSize * kSmallTileSize; ++i) {
          light += image.at(x + i % kSmallTileSize, y + i / kSmallTileSize, 1);
        }
        tiles += light > 0 ? 0 : 1;
      }
    }
    return tiles;
  }

  /// Sends the second signal: the program ends, and no file remains.
  void expect_second_signal_ends(int signal) {
    const std::string log = folder_.path("log");
    // One tile takes seconds, even with the first 1024 samples.
    Background program({"-v", scene_, "-o", image_, "-D", "width=32", "-D", "spp=4000000", "-D",
                        "integrator=path"},
                       log);
    ASSERT_TRUE(program.says("rendering 32x32"));
    program.send(signal);
    ASSERT_TRUE(program.says("interrupted"));
    program.send(signal);
    const auto sent = Clock::now();
    EXPECT_EQ(program.wait(), 128 + signal) << program.log();
    EXPECT_LT(Clock::now() - sent, std::chrono::seconds(5));
    EXPECT_EQ(other_files({scene_, log}), std::vector<std::string>{});
  }

  std::string scene_;
  std::string image_;
};

TEST_F(Interrupt, FirstSigintWritesTheImageSoFar) {
  expect_first_signal_writes(SIGINT);
}
TEST_F(Interrupt, FirstSigtermWritesTheImageSoFar) {
  expect_first_signal_writes(SIGTERM);
}
TEST_F(Interrupt, FirstSighupWritesTheImageSoFar) {
  signal(SIGHUP, SIG_DFL);  // tests may run under nohup, which programs inherit
  expect_first_signal_writes(SIGHUP);
}
TEST_F(Interrupt, PathsAreFilledIn) {
  expect_first_signal_writes(SIGINT, "path");
}
/// Filling in takes half a second on an idle machine. It may exceed the time limit on a busy
/// machine or with a sanitizer: then missing pixels are marked. test_interrupted uses a stopped
/// clock to test that they are filled in at any stage.
TEST_F(Interrupt, ClusteredIsFilledInOrMarked) {
  ImageMetadata metadata;
  const Image image = interrupted(SIGINT, "clustered", metadata);
  if (metadata["kinome:missing"] == "0") {
    expect_filled(image, metadata, 0);  // it may still be in its pilot
  } else {
    expect_marked(image, metadata);
  }
}

/// Pixels that would take too long are left out, and marked in an alpha channel.
TEST_F(Interrupt, PixelsThatTakeLongAreMarked) {
  std::string xml = read_text(scene_);
  const std::string integrator = "<integrator type=\"$integrator\"/>";
  xml.replace(xml.find(integrator), integrator.size(),
              "<integrator type=\"$integrator\"><integer name=\"emitter_samples\" value=\"" +
                  std::to_string(kManySamples) +
                  "\"/><integer name=\"bsdf_samples\" value=\"0\"/></integrator>");
  folder_.write("scene.xml", xml);
  const std::string log = folder_.path("log");
  // A pixel takes 65536 shadow rays, 4 billion in total. Few machines trace more than a hundred
  // million per second (34 million, and a hundredth of that).
  Background program({scene_, "-o", image_, "--png", "-t", "2", "-D", "width=256", "-D", "spp=1"},
                     log);
  ASSERT_TRUE(program.says("rendering: "));
  program.send(SIGINT);
  const auto sent = Clock::now();
  EXPECT_EQ(program.wait(), 128 + SIGINT) << program.log();
  EXPECT_LT(Clock::now() - sent, std::chrono::seconds(30));
  EXPECT_NE(program.log().find("missing (alpha 0 in an EXR)"), std::string::npos) << program.log();
  ImageMetadata metadata;
  const Image image = read_exr(image_, {}, &metadata);
  EXPECT_EQ(metadata["kinome:complete"], "false");
  expect_marked(image, metadata);
  EXPECT_LT(std::stod(metadata["kinome:missing"]), 1);
  for (int i = 0; i < 256 * 256; ++i) {
    ASSERT_EQ(image.at(i % 256, i / 256, 3), image.at(i % 256, i / 256, 1) > 0 ? 1 : 0) << i;
  }
}

/// Light paths cover the whole image at any time: nothing is filled in.
TEST_F(Interrupt, LightTracingHasNoGaps) {
  const std::string log = folder_.path("log");
  Background program({scene_, "-o", image_, "-t", "2", "-D", "width=64", "-D", "spp=40000", "-D",
                      "integrator=ptracer"},
                     log);
  ASSERT_TRUE(program.says("rendering: "));
  program.send(SIGINT);
  EXPECT_EQ(program.wait(), 128 + SIGINT) << program.log();
  ImageMetadata metadata;
  const Image image = read_exr(image_, {}, &metadata);
  EXPECT_EQ(metadata["kinome:filled"], "0");
  EXPECT_EQ(metadata["kinome:missing"], "0");
  EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
}

TEST_F(Interrupt, SecondSigintEndsAtOnce) {
  expect_second_signal_ends(SIGINT);
}
TEST_F(Interrupt, SecondSigtermEndsAtOnce) {
  expect_second_signal_ends(SIGTERM);
}

/// A render with the maximum number of samples shows progress, and has a whole image soon after its
/// start.
TEST_F(Interrupt, EndlessRendersGiveImages) {
  for (const char* integrator : {"direct", "clustered"}) {
    const std::string log = folder_.path("log");
    Background program({scene_, "-o", image_, "-t", "2", "-D", "width=8", "-D", "spp=1000000000",
                        "-D", std::string("integrator=") + integrator},
                       log);
    // A pilot and a plan report progress before there is an image.
    ASSERT_TRUE(program.says("rendering: ", integrator == std::string("clustered") ? 3 : 1));
    program.send(SIGINT);
    EXPECT_EQ(program.wait(), 128 + SIGINT) << program.log();
    EXPECT_NE(program.log().find("incomplete"), std::string::npos) << program.log();
    ImageMetadata metadata;
    const Image image = read_exr(image_, {}, &metadata);
    EXPECT_EQ(metadata["kinome:complete"], "false");
    for (int i = 0; i < 64; ++i) EXPECT_GT(image.at(i % 8, i / 8, 1), 0) << integrator;
  }
}

TEST_F(Interrupt, BudgetsEndWithTheImageSoFar) {
  const std::string log = folder_.path("log");
  for (const std::vector<std::string>& budget :
       {std::vector<std::string>{"--time", "1000"}, {"--error", "1e-12"}}) {
    std::vector<std::string> arguments = {scene_, "-o", image_, "-t", "2", "-D", "width=64"};
    arguments.insert(arguments.end(), budget.begin(), budget.end());
    Background program(arguments, log);
    ASSERT_TRUE(program.says("rendering: ")) << budget[0];
    program.send(SIGTERM);
    EXPECT_EQ(program.wait(), 128 + SIGTERM) << program.log();
    ImageMetadata metadata;
    const Image image = read_exr(image_, {}, &metadata);
    EXPECT_EQ(metadata["kinome:missing"], "0");
    EXPECT_EQ(dark_tiles(image), 0) << budget[0];
    // With few samples, as on a slow machine, some pixels find no light.
    if (std::stod(metadata["kinome:samples"]) < 64) continue;
    for (int i = 0; i < 64 * 64; ++i) EXPECT_GT(image.at(i % 64, i / 64, 1), 0) << budget[0];
  }
}

TEST_F(Interrupt, FolderThatCannotBeWrittenIsFoundFirst) {
  // This would take minutes if the error were found after the render.
  const std::vector<std::string> long_render = {scene_, "-D", "width=512", "-D", "spp=100000"};
  const auto fails = [&](const std::string& path, const std::string& part) {
    std::vector<std::string> arguments = long_render;
    arguments.insert(arguments.end(), {"-o", path});
    const auto start = Clock::now();
    expect_one_error(kinome(arguments), "", {path, part});
    EXPECT_LT(Clock::now() - start, std::chrono::seconds(20)) << path;
  };
  fails(folder_.path("nowhere/a.exr"), "does not exist");
  fails(scene_ + "/a.exr", "not");
  fails("/proc/a.exr", "cannot write");  // not even root can
  std::filesystem::create_directories(folder_.path("a_folder.exr"));
  fails(folder_.path("a_folder.exr"), "folder");
  if (geteuid() != 0) {  // root may write everywhere
    std::filesystem::create_directories(folder_.path("locked"));
    std::filesystem::permissions(folder_.path("locked"), std::filesystem::perms(0500));
    fails(folder_.path("locked/a.exr"), "cannot write");
  }
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
}

TEST_F(Interrupt, FolderAsOutputIsFoundFirst) {
  for (const std::string& output : {folder_.folder(), folder_.folder() + "/"}) {
    expect_one_error(kinome({scene_, "-o", output}), "", {output, "folder"});
  }
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
}

#ifndef KINOME_HAS_SANITIZER  // they reserve terabytes
TEST_F(Interrupt, TooLittleMemoryIsOneError) {
  const ProcessResult result =
      run_process({"sh", "-c", "ulimit -v 1500000; exec \"$@\"", "sh", KINOME_TEST_PROGRAM, scene_,
                   "-D", "width=30000", "-D", "spp=1"});
  expect_one_error(result, "", {"out of memory"});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
}

/// Any memory limit. The error must not blame the machine.
TEST_F(Interrupt, MemoryLimitsCauseOneError) {
  int failures = 0;
  for (int kilobytes = 60000; kilobytes < 400000; kilobytes += 20000) {
    SCOPED_TRACE(kilobytes);
    const ProcessResult result =
        run_process({"sh", "-c", "ulimit -v " + std::to_string(kilobytes) + "; exec \"$@\"", "sh",
                     KINOME_TEST_PROGRAM, "-q", scene_, "-o", image_, "-t", "4", "-D", "spp=1"});
    if (result.status == 0 || result.status == 127) continue;  // 127: no memory for libraries
    ++failures;
    expect_one_error(result, "", {"memory"});
  }
  EXPECT_GT(failures, 0);
}
#endif

TEST_F(Interrupt, FullDiskLeavesNoFile) {
  // The maximum file size is far smaller than the image: writes fail as on a full disk.
  const std::string limited = "ulimit -f 16; exec \"$@\"";
  const ProcessResult result =
      run_process({"sh", "-c", limited, "sh", KINOME_TEST_PROGRAM, "-q", scene_, "-o", image_, "-D",
                   "width=400", "-D", "spp=1"});
  expect_one_error(result, "", {image_, "cannot write"});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
}

TEST_F(Interrupt, FailedWriteKeepsTheOldImage) {
  folder_.write("a.exr", "the old picture");
  const ProcessResult result =
      run_process({"sh", "-c", "ulimit -f 16; exec \"$@\"", "sh", KINOME_TEST_PROGRAM, "-q", scene_,
                   "-o", image_, "-D", "width=400", "-D", "spp=1"});
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(read_text(image_), "the old picture");
  EXPECT_EQ(other_files({scene_, image_}), std::vector<std::string>{});
}

/// Starts the program on a terminal, whose output `master` receives.
pid_t start_on_terminal(const std::vector<std::string>& arguments, int& master) {
  std::vector<char*> argv = {const_cast<char*>(KINOME_TEST_PROGRAM)};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  winsize size{24, 72, 0, 0};
  const pid_t child = forkpty(&master, nullptr, nullptr, &size);
  if (child == 0) {
    signal(SIGHUP, SIG_DFL);  // tests may run under nohup, which programs inherit
    execv(argv[0], argv.data());
    _exit(127);
  }
  return child;
}

std::string on_terminal(const std::vector<std::string>& arguments) {
  int master = -1;
  const pid_t child = start_on_terminal(arguments, master);
  std::string text;
  char buffer[4096];
  for (ssize_t n = 0; (n = read(master, buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<size_t>(n));
  }
  close(master);
  waitpid(child, nullptr, 0);
  return text;
}

TEST_F(Interrupt, BarOnATerminal) {
  // Long enough for the progress bar to be drawn, some tenths of a second.
  const std::vector<std::string> arguments = {scene_, "-D", "width=256", "-D",
                                              "spp=" + std::to_string(kSamplesOfTenths)};
  const std::string text = on_terminal(arguments);
  EXPECT_NE(text.find("\r["), std::string::npos) << text;
  EXPECT_NE(text.find(" %, "), std::string::npos) << text;
  EXPECT_NE(text.find(" s left"), std::string::npos) << text;
  EXPECT_EQ(text.find("rendering: "), std::string::npos) << text;
  std::vector<std::string> quiet = arguments;
  quiet.push_back("-q");
  EXPECT_EQ(on_terminal(quiet), "");
}

/// No message can be printed any more, but the image is written.
TEST_F(Interrupt, ATerminalThatIsClosed) {
  int master = -1;
  const pid_t child = start_on_terminal(
      {scene_, "-o", image_, "-t", "2", "-D", "width=256", "-D", "spp=40000"}, master);
  std::string text;
  char buffer[4096];
  for (ssize_t n = 0; text.find(" %") == std::string::npos; text.append(buffer, size_t(n))) {
    n = read(master, buffer, sizeof buffer);
    ASSERT_GT(n, 0) << text;
  }
  close(master);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ImageMetadata metadata;
  read_exr(image_, {}, &metadata);
  EXPECT_EQ(metadata["kinome:complete"], "false");
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 128 + SIGHUP) << status;
}

TEST_F(Interrupt, PlainLinesInALog) {
  const std::string log = folder_.path("log");
  const Background program({scene_, "-t", "2", "-D", "width=256", "-D", "spp=40000"}, log);
  ASSERT_TRUE(program.says(" left\n"));
  EXPECT_EQ(program.log().rfind("rendering: ", 0), 0u) << program.log();
  EXPECT_NE(program.log().find(" % done, "), std::string::npos) << program.log();
  EXPECT_EQ(program.log().find('\r'), std::string::npos) << program.log();
  const ProcessResult whole = kinome({scene_});
  EXPECT_EQ(whole.err.rfind("wrote " + folder_.path("scene.exr"), 0), 0u) << whole.err;
}

}  // namespace
}  // namespace kinome::test
