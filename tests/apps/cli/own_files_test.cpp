/// Tests that no command overwrites a file that it has read or removes a file that it has not made,
/// and that a scene finds its own files wherever the program is started.
#include <sys/stat.h>

#include "cli.h"
#include "kinome/image_files.h"

namespace kinome::test::own_files_test {
namespace {

namespace fs = std::filesystem;

class OwnFiles : public Cli {
 protected:
  void SetUp() override {
    map_ = folder_.path("sky.exr");
    write_map(map_, {0.2f, 0.5f, 0.9f});
    scene_ = folder_.write("sky.xml", text("sky.exr"));
  }

  static void write_map(const std::string& path, const Rgb& color) {
    Image image{4, 2, {"R", "G", "B"}, {}};
    for (int i = 0; i < 8; ++i) image.data.insert(image.data.end(), {color.x, color.y, color.z});
    write_exr(path, image, ExrSampleType::kFloat, {});
  }

  static std::string text(const std::string& map, const std::string& path = "") {
    return R"(<scene version="3.0.0">)" + path + R"(<integrator type="path"/>
  <sensor type="perspective"><sampler type="independent"/><film type="hdrfilm">
    <integer name="width" value="4"/><integer name="height" value="4"/></film></sensor>
  <emitter type="envmap"><string name="filename" value=")" +
           map + R"("/></emitter></scene>)";
  }

  /// Runs a command that must fail before it renders, because it would overwrite the map.
  void expect_refusal(std::vector<std::string> arguments) {
    const std::string before = read_text(map_);
    arguments.insert(arguments.begin(), scene_);
    const ProcessResult result = kinome(arguments);
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.err.find("is never overwritten"), std::string::npos) << result.err;
    EXPECT_EQ(lines(result.err), 1u) << result.err;
    EXPECT_TRUE(read_text(map_) == before);
  }

  static Rgb color_of(const std::string& path) {
    const Image image = read_exr(path);
    return {image.data[0], image.data[1], image.data[2]};
  }

  std::string map_, scene_;
};

TEST_F(OwnFiles, ImageAndPngAreTwoFiles) {
  fs::create_symlink("a.exr", folder_.path("a.png"));
  expect_one_error(kinome({"-q", scene_, "-o", folder_.path("a.exr"), "--png"}), "",
                   {"--png: ", "are the same file"});
  EXPECT_FALSE(fs::exists(folder_.path("a.exr")));
}

TEST_F(OwnFiles, AnImageNeverReplacesAMap) {
  expect_refusal({"-q"});
  expect_refusal({"-q", "-o", map_});
  fs::create_symlink("sky.exr", folder_.path("link.exr"));
  expect_refusal({"-q", "-o", folder_.path("link.exr")});
  fs::create_hard_link(map_, folder_.path("hard.exr"));
  expect_refusal({"-q", "-o", folder_.path("hard.exr")});
}

TEST_F(OwnFiles, APngNeverReplacesATexture) {
  const std::string texture = folder_.path("wall.png");
  write_png(texture, Image{1, 1, {"R", "G", "B"}, {1, 1, 1}}, 0);
  const std::string before = read_text(texture);
  const std::string scene =
      folder_.write("wall.xml", R"(<scene version="3.0.0"><sensor type="perspective"/>
  <shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
  <string name="filename" value="wall.png"/></texture></bsdf></shape></scene>)");
  const ProcessResult result = kinome({scene, "-q", "--png"});
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("wall.png': this file was read"), std::string::npos) << result.err;
  EXPECT_TRUE(read_text(texture) == before);
  EXPECT_FALSE(fs::exists(folder_.path("wall.exr")));
}

TEST_F(OwnFiles, AMergedImageNeverReplacesAPart) {
  for (const char* part : {"1/2", "2/2"}) {
    const std::string file = folder_.path(part[0] + std::string(".exr"));
    ASSERT_EQ(kinome({scene_, "-q", "--part", part, "-o", file}).status, 0);
  }
  const std::string one = folder_.path("1.exr"), two = folder_.path("2.exr");
  const std::string before = read_text(two);
  const ProcessResult result = kinome({"merge", one, two, "-q", "-o", two});
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("2.exr': this file was read"), std::string::npos) << result.err;
  EXPECT_TRUE(read_text(two) == before);
}

TEST_F(OwnFiles, AFrameOfAFilmNeverReplacesAMap) {
  write_map(folder_.path("f1.exr"), Rgb(1.f));
  folder_.write("ffilm.json", "{}");
  const std::string scene = folder_.write("f.xml", text("f1.exr"));
  const std::string before = read_text(folder_.path("f1.exr"));
  const ProcessResult result = kinome({"film", scene, "-q", "-o", folder_.path("f%d.exr"), "--path",
                                       "orbit", "--target", "0,0,5", "--frames", "3"});
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("f1.exr': this file was read"), std::string::npos) << result.err;
  EXPECT_TRUE(read_text(folder_.path("f1.exr")) == before);
}

TEST_F(OwnFiles, FilesBesideTheImageStay) {
  std::vector<std::string> own{scene_, map_};
  for (const char* name : {"a.timing.exr", "a.timing.png", "a.exr.picture.exr"}) {
    own.push_back(folder_.write(name, "precious"));
  }
  const std::string image = folder_.path("a.exr");
  EXPECT_EQ(kinome({scene_, "-q", "--png", "--time", "0.3", "-o", image}).status, 0);
  EXPECT_EQ(kinome({scene_, "-q", "--part", "1/2", "-o", image}).status, 0);
  for (size_t i = 2; i < own.size(); ++i) EXPECT_EQ(read_text(own[i]), "precious") << own[i];
  const std::vector<std::string> others = other_files(own);
  EXPECT_EQ(others.size(), 2u);  // a.exr and a.png
  for (const auto& entry : fs::directory_iterator(folder_.folder())) {
    EXPECT_FALSE(entry.is_directory()) << entry.path();
  }
}

TEST_F(OwnFiles, TheSceneFolderComesFirst) {
  fs::create_directories(folder_.path("there/maps"));
  write_map(folder_.path("there/card.exr"), {0.5f, 0.f, 0.f});
  write_map(folder_.path("there/maps/card.exr"), {0.f, 0.5f, 0.f});
  write_map(folder_.path("there/maps/other.exr"), {0.f, 0.5f, 0.f});
  for (const char* name : {"card.exr", "other.exr", "third.exr"}) {
    write_map(folder_.path(name), {0.f, 0.f, 0.5f});
  }
  const std::string path = R"(<path value="maps"/>)";
  const std::string image = folder_.path("image.exr");
  // Started in the folder above the scene's.
  const auto seen = [&](const std::string& map, const std::string& warning) {
    folder_.write("there/t.xml", text(map, path));
    const ProcessResult result =
        run_process({"/bin/sh", "-c",
                     "cd '" + folder_.folder() + "' && '" + std::string(KINOME_TEST_PROGRAM) +
                         "' there/t.xml -o image.exr 2>&1"},
                    60);
    EXPECT_EQ(result.status, 0) << result.out;
    const bool warns = result.out.find("only in the working directory") != std::string::npos;
    EXPECT_EQ(warns, !warning.empty()) << result.out;
    EXPECT_NE(result.out.find(warning), std::string::npos) << result.out;
    return color_of(image);
  };
  EXPECT_GT(seen("card.exr", "").x, 0.4f);
  EXPECT_GT(seen("other.exr", "").y, 0.4f);
  EXPECT_GT(seen("third.exr", "there/t.xml:4:26").z, 0.4f);
}

TEST_F(OwnFiles, NamesOfImagesMayHaveUpperCaseExtensions) {
  EXPECT_EQ(kinome({scene_, "-q", "-o", folder_.path("A.EXR"), "--png"}).status, 0);
  EXPECT_TRUE(fs::exists(folder_.path("A.EXR")));
  EXPECT_TRUE(fs::exists(folder_.path("A.png")));
  EXPECT_FALSE(fs::exists(folder_.path("A.EXR.exr")));
  EXPECT_EQ(kinome({scene_, "-q", "-o", folder_.path("B.PNG"), "--png"}).status, 0);
  EXPECT_TRUE(fs::exists(folder_.path("B.PNG")));
  EXPECT_FALSE(fs::exists(folder_.path("B.png")));
}

TEST_F(OwnFiles, TheNullDeviceTakesAnyImage) {
  EXPECT_EQ(kinome({scene_, "-q", "-o", "/dev/null", "--png", "--time", "0.2"}).status, 0);
  const std::string checkpoint = folder_.path("checkpoint");
  EXPECT_EQ(kinome({scene_, "-q", "-o", "/dev/null", "--checkpoint", checkpoint}).status, 0);
  struct stat status {};
  ASSERT_EQ(::stat("/dev/null", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
  EXPECT_FALSE(fs::exists("/dev/null.exr"));
  expect_one_error(kinome({scene_, "-o", "/dev/full"}), "", {"it exists and is not a regular"});
  EXPECT_EQ(other_files({scene_, map_}), std::vector<std::string>{});
}

TEST_F(OwnFiles, AFullDiskBehindStdoutIsAnError) {
  const auto status = [](const std::string& arguments) {
    return run_process(
        {"/bin/sh", "-c", std::string(KINOME_TEST_PROGRAM) + " " + arguments + " > /dev/full"},
        120);
  };
  for (const std::string& arguments :
       {std::string("--help"), std::string("--man"), std::string("plugins"),
        std::string("plugins --markdown"), "--check " + scene_,
        scene_ + " -q --stats=json -o /dev/null"}) {
    const ProcessResult result = status(arguments);
    EXPECT_EQ(result.status, 1) << arguments;
    EXPECT_NE(result.err.find("stdout can't be written: No space left"), std::string::npos)
        << arguments << ": " << result.err;
  }
  EXPECT_EQ(status("check diffuse --effort 0.01 --only registry").status, 2);
}

}  // namespace
}  // namespace kinome::test::own_files_test
