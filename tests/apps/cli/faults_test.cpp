// Tests of external faults: the program is killed, memory or the disk is full, files change while
// they are read, another run writes the same file. It must never crash, and never leave a partial
// file; one line reports the error.

#include <csignal>
#include <cstdlib>
#include <random>

#include <unistd.h>

#include "background.h"
#include "cli.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::test::faults_test {
namespace {

namespace fs = std::filesystem;

class Faults : public Cli {
 protected:
  Faults() : scene_(folder_.write("scene.xml", small_scene())), image_(folder_.path("a.exr")) {}

  /// Runs the program after a shell's `prefix`, such as "ulimit -v 1000;".
  ProcessResult under(const std::string& prefix, const std::vector<std::string>& arguments) const {
    std::vector<std::string> all = {"sh", "-c", prefix + " exec \"$@\"", "sh", KINOME_TEST_PROGRAM};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_process(all);
  }
  std::string scene_, image_;
};

/// Kills a run that takes longer to write than to render, at any moment: the image is complete, or
/// the old one.
TEST_F(Faults, KilledAnywhereLeavesACompleteImageOrTheOldOne) {
  const std::string log = folder_.path("log");
  const std::vector<std::string> render = {scene_,      "-o", image_,  "--png", "-D",
                                           "width=700", "-D", "spp=1", "-D",    "integrator=depth"};
  ASSERT_EQ(kinome(render).status, 0);
  const std::string whole = read_text(image_), png = read_text(folder_.path("a.png"));
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    folder_.write("a.exr", "old");
    Background program(render, log);
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 250));
    program.send(SIGKILL);
    program.wait();
    const std::string found = read_text(image_);
    EXPECT_TRUE(found == "old" || found == whole) << found.size() << " bytes";
    EXPECT_EQ(read_text(folder_.path("a.png")), png);
    EXPECT_LE(other_files({scene_, log, image_, folder_.path("a.png")}).size(), 1u);
  }
}

/// Two runs write one file: it contains the image of one of them.
TEST_F(Faults, TwoRunsOfOneFile) {
  const auto run = [&](const std::string& width, const std::string& log) {
    return std::make_unique<Background>(
        std::vector<std::string>{"-q", scene_, "-o", image_, "-D", "width=" + width, "-D", "spp=1"},
        folder_.path(log));
  };
  std::vector<std::string> whole;
  for (const char* width : {"300", "310"}) {
    ASSERT_EQ(run(width, "log")->wait(), 0);
    whole.push_back(read_text(image_));
  }
  for (int i = 0; i < 8; ++i) {
    const auto a = run("300", "log_a"), b = run("310", "log_b");
    EXPECT_EQ(a->wait(), 0);
    EXPECT_EQ(b->wait(), 0);
    const std::string found = read_text(image_);
    EXPECT_TRUE(found == whole[0] || found == whole[1]);
  }
  EXPECT_EQ(other_files({scene_, image_}).size(), 3u);  // the logs
}

#ifndef KINOME_HAS_SANITIZER
/// Memory limits from too little for the program to start to enough: one error line, or the image.
TEST_F(Faults, MemoryEndsAnywhere) {
  std::string xml = small_scene();  // without a bounce, whose light points take long
  const std::string end = "\"$integrator\"/>";
  xml.replace(xml.find(end), end.size(),
              "\"$integrator\"><integer name=\"max_depth\" value=\"2\"/></integrator>");
  folder_.write("scene.xml", xml);
  // Returns true if the complete image exists.
  const auto does = [&](int kilobytes) {
    SCOPED_TRACE(kilobytes);
    const ProcessResult result =
        under("ulimit -v " + std::to_string(kilobytes) + ";",
              {"-q", scene_, "-o", image_, "-t", "2", "-D", "width=1000", "-D", "spp=1", "-D",
               "integrator=clustered"});
    if (result.status == 0) {
      EXPECT_EQ(read_exr(image_).width, 1000);
      fs::remove(image_);
      return true;
    }
    if (result.status == 127) return false;  // too little memory for the libraries
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_EQ(lines(result.err), 1u) << result.err;
    EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
    return false;
  };
  int too_little = 150 * 1024, enough = too_little;
  while (enough < 1400 * 1024 && !does(enough)) {
    too_little = enough;
    enough += 125 * 1024;
  }
  ASSERT_LT(too_little, enough);
  ASSERT_LT(enough, 1400 * 1024);
  // Finds a limit at which only the last step fails: OpenEXR would then write an image with holes.
  while (enough - too_little > 256) {
    const int middle = (too_little + enough) / 2;
    (does(middle) ? enough : too_little) = middle;
  }
}

/// A preloaded library makes a disk full after `bytes` bytes.
TEST_F(Faults, FullDisk) {
  const auto run = [&](size_t bytes, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-q", scene_, "-D", "width=200", "-D", "spp=4"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return under("LD_PRELOAD=" KINOME_TEST_FULL_DISK " KINOME_TEST_DISK=" + std::to_string(bytes),
                 arguments);
  };
  // With enough space, the test itself must succeed.
  ASSERT_EQ(run(100 << 20, {"-o", image_}).status, 0);
  const auto size = fs::file_size(image_);
  fs::remove(image_);
  for (const size_t room : {size_t{10}, size_t{size / 2}, size_t{size - 1}}) {
    expect_one_error(run(room, {"-o", image_}), "", {image_, "No space left on device"});
    EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
  }
  // There is space for the image (its table is written twice), but not for the PNG beside it.
  const std::string png = folder_.path("a.png");
  expect_one_error(run(size + 3000, {"-o", image_, "--png"}), "", {png, "No space left on device"});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{image_});
  fs::remove(image_);
  const std::string scene = read_text(scene_);
  folder_.write("scene.xml",
                std::string(scene).replace(scene.find("<rfilter"), 0,
                                           "<string name='file_format' value='pfm'/>"));
  const std::string pfm = folder_.path("a.pfm");
  expect_one_error(run(1000, {"-o", pfm}), "", {pfm, "No space left on device"});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
}

/// A checkpoint that can't be written causes a warning, and an existing one is kept. An image that
/// can't be written isn't lost.
TEST_F(Faults, FullDiskWithCheckpoints) {
  const std::string checkpoint = folder_.path("c");
  const std::vector<std::string> arguments = {scene_,    "-o", image_, "--checkpoint", checkpoint,
                                              "--every", "0",  "-D",   "width=200",    "--resume"};
  const auto run = [&](size_t bytes) {
    return under("LD_PRELOAD=" KINOME_TEST_FULL_DISK " KINOME_TEST_DISK=" + std::to_string(bytes),
                 arguments);
  };
  const ProcessResult warned = run(1 << 20);  // less than the 1.3 MB of one checkpoint
  EXPECT_EQ(warned.status, 0) << warned.err;
  EXPECT_NE(warned.err.find("warning: cannot write '" + checkpoint + "': No space left"),
            std::string::npos)
      << warned.err;
  const std::string whole = read_text(image_);
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{image_});
  fs::remove(image_);

  // There is space for three checkpoints, but not for the render's last one and the image.
  const ProcessResult failed = run(3900000);
  EXPECT_EQ(failed.status, 1) << failed.err;
  EXPECT_NE(failed.err.find("kinome: cannot write '" + image_ + "': No space left"),
            std::string::npos)
      << failed.err;
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{checkpoint});
  const ProcessResult resumed = kinome(arguments);
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(read_text(image_), whole);
}
#endif

/// Another process truncates the file while the program reads it.
TEST_F(Faults, FilesThatShrinkWhileTheyAreRead) {
  std::string obj, ply =
                       "ply\nformat binary_little_endian 1.0\nelement vertex 200000\n"
                       "property float x\nproperty float y\nproperty float z\n"
                       "element face 100000\nproperty list uchar int vertex_indices\n"
                       "end_header\n";
  std::mt19937 random(5);
  const auto put = [&](auto value) {
    ply.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (int i = 0; i < 200000; ++i) {
    for (int c = 0; c < 3; ++c) put(static_cast<float>(random() % 1000));
  }
  for (int i = 0; i < 100000; ++i) {
    put(uint8_t{3});
    for (int c = 0; c < 3; ++c) put(static_cast<int32_t>((2 * i + c) % 200000));
    obj += "v " + std::to_string(random() % 1000) + " " + std::to_string(i) + " 1\n";
  }
  for (int i = 1; i + 2 < 100000; ++i) {
    obj +=
        "f " + std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + 2) + "\n";
  }
  Image map{1024, 512, {"R", "G", "B"}, std::vector<float>(1024 * 512 * 3)};
  for (float& value : map.data) value = static_cast<float>(random() % 100);
  write_exr(folder_.path("map.exr"), map, ExrSampleType::kFloat, {});
  const struct {
    const char* name;
    std::string contents, xml;
  } files[] = {
      {"a.ply", ply, "<shape type='ply'><string name='filename' value='a.ply'/></shape>"},
      {"a.obj", obj, "<shape type='obj'><string name='filename' value='a.obj'/></shape>"},
      {"map.exr", read_text(folder_.path("map.exr")),
       "<emitter type='envmap'><string name='filename' value='map.exr'/></emitter>"},
  };
  for (const auto& file : files) {
    std::string xml = small_scene();
    xml.replace(xml.find("<emitter type=\"constant\"/>"), 26, file.xml);
    const std::string scene = folder_.write("mine.xml", xml);
    for (int i = 0; i < 6; ++i) {
      const std::string path = folder_.write(file.name, file.contents);
      const std::string log = folder_.path("log");
      Background program({"-q", scene, "-o", image_, "-D", "width=16", "-D", "spp=1"}, log);
      std::this_thread::sleep_for(std::chrono::milliseconds(10 + random() % 60));
      fs::resize_file(path, file.contents.size() / (2 + random() % 7));
      const int status = program.wait();
      EXPECT_TRUE(status == 0 || status == 1) << file.name << ": " << status << program.log();
      EXPECT_LE(lines(program.log()), 1u) << program.log();
      if (status == 1) {
        EXPECT_NE(program.log().find(file.name), std::string::npos) << program.log();
      }
    }
  }
}

#ifndef KINOME_HAS_SANITIZER  // they report crashes themselves
/// Wherever the program crashes. A preloaded library crashes it when an image is complete but not
/// yet renamed.
TEST_F(Faults, CrashesRemoveTemporaryFiles) {
  const std::string log = folder_.path("log");
  Background program({"-v", scene_, "-o", image_, "-D", "spp=1000000"}, log);
  ASSERT_TRUE(program.says("rendering 48x48"));
  program.send(SIGABRT);
  EXPECT_EQ(program.wait(), 128 + SIGABRT);
  EXPECT_NE(program.log().find("crashed (SIGABRT) while rendering"), std::string::npos)
      << program.log();
  EXPECT_EQ(other_files({scene_, log}), std::vector<std::string>{});

  const ProcessResult result =
      under("LD_PRELOAD=" KINOME_TEST_CRASH_AT_RENAME, {scene_, "-o", image_});
  EXPECT_EQ(result.status, 128 + SIGABRT) << result.err;
  EXPECT_NE(result.err.find("crashed (SIGABRT) while writing the image"), std::string::npos)
      << result.err;
  EXPECT_EQ(other_files({scene_, log}), std::vector<std::string>{});
}
#endif

}  // namespace
}  // namespace kinome::test::faults_test
