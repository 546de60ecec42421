// What the world does to a program: it is killed, memory and disks are full, files change while
// they are read, plugins misbehave, another run writes the same file. Never a crash, never half a
// file; one line says what is wrong.

#include <csignal>
#include <cstdlib>
#include <random>
#include <tuple>

#include <unistd.h>

#include "background.h"
#include "cli.h"
#include "kinome/image.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;

class Faults : public Cli {
 protected:
  Faults() : scene_(folder_.write("scene.xml", small_scene())), image_(folder_.path("a.exr")) {}

  /// Under a shell's `prefix`, such as "ulimit -v 1000;".
  ProcessResult under(const std::string& prefix, const std::vector<std::string>& arguments) const {
    std::vector<std::string> all = {"sh", "-c", prefix + " exec \"$@\"", "sh", KINOME_TEST_PROGRAM};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_process(all);
  }
  std::string scene_, image_;
};

/// At any moment of a run that writes more than it renders: the picture is whole, or the old one.
TEST_F(Faults, KilledAnywhereLeavesAWholePictureOrTheOldOne) {
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

/// Two runs, one file: the picture of one of them.
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

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// From too little for the program to begin, to enough for all: one line, or the picture.
TEST_F(Faults, MemoryEndsAnywhere) {
  std::string xml = small_scene();  // without a bounce, whose light points take long
  const std::string end = "\"$integrator\"/>";
  xml.replace(xml.find(end), end.size(),
              "\"$integrator\"><integer name=\"max_depth\" value=\"2\"/></integrator>");
  folder_.write("scene.xml", xml);
  bool failed = false, succeeded = false;
  for (int megabytes = 150; megabytes < 1400; megabytes += 125) {
    const ProcessResult result = under("ulimit -v " + std::to_string(megabytes * 1024) + ";",
                                       {"-q", scene_, "-o", image_, "-t", "2", "-D", "width=2000",
                                        "-D", "spp=1", "-D", "integrator=clustered"});
    if (result.status == 127) continue;  // not even the libraries fit
    SCOPED_TRACE(megabytes);
    if (result.status == 0) {
      succeeded = true;
      EXPECT_EQ(read_exr(image_).width, 2000);
      break;  // more memory tells nothing more
    }
    failed = true;
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_EQ(lines(result.err), 1u) << result.err;
    EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
  }
  EXPECT_TRUE(failed);
  EXPECT_TRUE(succeeded);
}

/// A preloaded library lets a disk run full after so many bytes.
TEST_F(Faults, FullDisk) {
  const auto run = [&](size_t bytes, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-q", scene_, "-D", "width=200", "-D", "spp=4"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return under("LD_PRELOAD=" KINOME_TEST_FULL_DISK " KINOME_TEST_DISK=" + std::to_string(bytes),
                 arguments);
  };
  // With room enough, nothing is in the way of the test itself.
  ASSERT_EQ(run(100 << 20, {"-o", image_}).status, 0);
  const auto size = fs::file_size(image_);
  fs::remove(image_);
  for (const size_t room : {size_t{10}, size_t{size / 2}, size_t{size - 1}}) {
    expect_one_error(run(room, {"-o", image_}), "", {image_, "No space left on device"});
    EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
  }
  // The picture has room (its table is written twice), but not the one for people beside it.
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

/// A checkpoint that can't be written is a warning, one that is there stays as it is, and a picture
/// that can't be written is not lost.
TEST_F(Faults, FullDiskWithCheckpoints) {
  const std::string checkpoint = folder_.path("c");
  const std::vector<std::string> arguments = {scene_,    "-o", image_, "--checkpoint", checkpoint,
                                              "--every", "0",  "-D",   "width=200",    "--resume"};
  const auto run = [&](size_t bytes) {
    return under("LD_PRELOAD=" KINOME_TEST_FULL_DISK " KINOME_TEST_DISK=" + std::to_string(bytes),
                 arguments);
  };
  const ProcessResult warned = run(1 << 20);  // of the 1.3 MB of one checkpoint
  EXPECT_EQ(warned.status, 0) << warned.err;
  EXPECT_NE(warned.err.find("warning: cannot write '" + checkpoint + "': No space left"),
            std::string::npos)
      << warned.err;
  const std::string whole = read_text(image_);
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{image_});
  fs::remove(image_);

  // Three checkpoints have room; the last one of the render, and the picture, have not.
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

/// Cut off, by someone else, while the program reads it.
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
  write_exr(folder_.path("map.exr"), map, false, {});
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

class FaultyPlugins : public Faults {
 protected:
  /// A scene whose sphere, sky and integrator are as given.
  ProcessResult run(const std::string& bsdf, const std::string& sky, const std::string& integrator,
                    std::vector<std::string> options = {}) {
    const std::string xml = R"(<scene version="3.0.0">
  )" + integrator + R"(
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0 2 4" target="0 .5 0" up="0 1 0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
    <film type="hdrfilm"> <integer name="width" value="64"/> <integer name="height" value="48"/>
      <rfilter type="box"/> </film>
  </sensor>
  )" + sky + R"(
  <shape type="sphere"><point name="center" value="0 1 0"/>)" +
                            bsdf + R"(</shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="-90"/> <scale value="3"/></transform>
  </shape>
</scene>)";
    scene_ = folder_.write("scene.xml", xml);
    options.insert(options.begin(), {scene_, "-o", image_, "-t", "2"});
    return run_process(with_plugins(options));
  }
  static std::vector<std::string> with_plugins(const std::vector<std::string>& options) {
    std::vector<std::string> all = {KINOME_TEST_PROGRAM, "--plugin-path", KINOME_TEST_FAULTY};
    all.insert(all.end(), options.begin(), options.end());
    return all;
  }
  static std::string faulty(const std::string& tag, const std::string& fault,
                            const std::string& attributes = "") {
    return "<" + tag + " type=\"faulty\" " + attributes + "><string name=\"fault\" value=\"" +
           fault + "\"/></" + tag + ">";
  }
  /// A square above the scene that shines downward.
  static std::string lamp(const std::string& emitter) {
    return R"(<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/>)"
           R"(<translate y="3"/></transform>)" +
           emitter + "</shape>";
  }
  void expect_failure(const ProcessResult& result, const std::vector<std::string>& parts) {
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_EQ(lines(result.err), 1u) << result.err;
    for (const std::string& part : parts) {
      EXPECT_NE(result.err.find(part), std::string::npos) << part << " in " << result.err;
    }
    EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
  }

  const std::string sky_ = R"(<emitter type="constant"/>)";
  const std::string direct_ = R"(<integrator type="direct"/>)";
};

TEST_F(FaultyPlugins, ThatThrowAreNamed) {
  // In construction, with its place.
  expect_failure(run(faulty("bsdf", "construction"), sky_, direct_),
                 {"scene.xml:10:60: plugin 'bsdf/faulty' failed: can't construct"});
  expect_failure(run(faulty("bsdf", "no exception in construction"), sky_, direct_),
                 {"scene.xml:10:60: plugin 'bsdf/faulty' failed"});
  // On worker threads.
  for (const char* integrator : {"direct", "path", "ptracer", "groundtruth", "clustered"}) {
    SCOPED_TRACE(integrator);
    const std::string xml = "<integrator type=\"" + std::string(integrator) + "\"/>";
    expect_failure(run(faulty("bsdf", "eval"), sky_, xml),
                   {"kinome: plugin 'bsdf/faulty' failed: can't evaluate"});
  }
  expect_failure(run(faulty("bsdf", "no exception"), sky_, direct_), {"plugin 'bsdf/faulty'"});
  expect_failure(run(faulty("bsdf", "range"), sky_, direct_), {"plugin 'bsdf/faulty'"});
  expect_failure(run(faulty("bsdf", "memory"), sky_, direct_), {"out of memory"});
  expect_failure(run("", faulty("emitter", "eval"), direct_),
                 {"plugin 'emitter/faulty' failed: can't shine"});
  const std::string textured =
      "<bsdf type=\"diffuse\">" + faulty("texture", "eval", "name=\"reflectance\"") + "</bsdf>";
  expect_failure(run(textured, sky_, direct_),
                 {"plugin 'texture/faulty' failed: can't be looked up"});
  for (const char* fault : {"render", "worker", "preparing"}) {
    SCOPED_TRACE(fault);
    expect_failure(run("", sky_, faulty("integrator", fault)),
                   {"kinome: plugin 'integrator/faulty' failed: can't"});
  }
  // In the middle of Embree's work.
  for (const char* fault : {"bounds", "intersect", "interaction"}) {
    SCOPED_TRACE(fault);
    expect_failure(run("", sky_ + faulty("shape", fault), direct_),
                   {"plugin 'shape/faulty' failed: can't be"});
  }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they tell of crashes
TEST_F(FaultyPlugins, ThatCrashAreNamed) {
  const auto expect_crash = [&](const ProcessResult& result, int signal, const std::string& line) {
    EXPECT_EQ(result.status, 128 + signal) << result.err;
    EXPECT_EQ(result.err, "kinome: " + line + "\n");
    EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
  };
  const std::tuple<const char*, int, const char*> crashes[] = {
      {"SIGSEGV", SIGSEGV, "SIGSEGV"},
      {"SIGFPE", SIGFPE, "SIGFPE"},
      {"SIGILL", SIGILL, "SIGILL"},
      {"SIGBUS", SIGBUS, "SIGBUS"},
      {"SIGABRT", SIGABRT, "SIGABRT"},
      {"stack overflow", SIGSEGV, "SIGSEGV, stack overflow"},
      {"call of nowhere", SIGSEGV, "SIGSEGV"},
  };
  for (const auto& [how, signal, name] : crashes) {
    SCOPED_TRACE(how);
    const std::string crashed = std::string(" crashed (") + name + ") while ";
    expect_crash(run(faulty("bsdf", std::string("crash in construction by ") + how), sky_, direct_),
                 signal, "plugin 'bsdf/faulty'" + crashed + "loading the scene");
    // On worker threads, all at once.
    expect_crash(run(faulty("bsdf", std::string("crash in eval by ") + how), sky_, direct_), signal,
                 "plugin 'bsdf/faulty'" + crashed + "rendering");
  }
  const std::string segv = " crashed (SIGSEGV) while ";
  for (const char* integrator : {"path", "ptracer", "groundtruth", "clustered"}) {
    SCOPED_TRACE(integrator);
    expect_crash(run(faulty("bsdf", "crash in eval by SIGSEGV"), sky_,
                     "<integrator type=\"" + std::string(integrator) + "\"/>"),
                 SIGSEGV, "plugin 'bsdf/faulty'" + segv + "rendering");
  }
  // The innermost of those that are at work, also within Embree.
  expect_crash(
      run("<bsdf type=\"twosided\">" + faulty("bsdf", "crash in eval by SIGSEGV") + "</bsdf>", sky_,
          direct_),
      SIGSEGV, "plugin 'bsdf/faulty'" + segv + "rendering");
  expect_crash(run("", faulty("emitter", "crash in eval by SIGSEGV"), direct_), SIGSEGV,
               "plugin 'emitter/faulty'" + segv + "rendering");
  expect_crash(run("", sky_ + faulty("shape", "crash in intersect by SIGSEGV"), direct_), SIGSEGV,
               "plugin 'shape/faulty'" + segv + "rendering");
  expect_crash(run("", sky_, faulty("integrator", "crash in render by SIGSEGV")), SIGSEGV,
               "plugin 'integrator/faulty'" + segv + "rendering");
  // What a plugin calls may be to blame as well.
  expect_crash(run("", sky_, faulty("integrator", "crash in the core")), SIGSEGV,
               "crashed (SIGSEGV) while rendering, called by plugin 'integrator/faulty'");
  // Before anything of it is known but its name.
  const std::string textured =
      "<bsdf type=\"diffuse\">" + faulty("texture", "none", "name=\"reflectance\"") + "</bsdf>";
  setenv("KINOME_TEST_CRASH", "1", 1);
  expect_crash(run(textured, sky_, direct_), SIGSEGV,
               "plugin 'texture/faulty'" + segv + "loading the scene");
  unsetenv("KINOME_TEST_CRASH");
}

TEST_F(Faults, CrashesRemoveTemporaryFiles) {
  const std::string log = folder_.path("log");
  Background program({"-v", scene_, "-o", image_, "-D", "spp=1000000"}, log);
  ASSERT_TRUE(program.says("rendering 48x48"));
  program.send(SIGABRT);
  EXPECT_EQ(program.wait(), 128 + SIGABRT);
  EXPECT_NE(program.log().find("crashed (SIGABRT) while rendering"), std::string::npos)
      << program.log();
  EXPECT_EQ(other_files({scene_, log}), std::vector<std::string>{});
}
#endif

/// Nothing that a plugin says is silently left out: the picture is written, the plugin named, its
/// faults counted, and the exit status is 3 unless told otherwise.
TEST_F(FaultyPlugins, ThatSayNonsenseAreNamedAndCounted) {
  const auto expect_fault = [&](const std::string& bsdf, const std::string& sky,
                                const std::string& integrator, const std::string& who,
                                const std::string& what) {
    SCOPED_TRACE(who + " " + what);
    for (const bool lenient : {false, true}) {
      const ProcessResult result =
          run(bsdf, sky, integrator,
              lenient ? std::vector<std::string>{"--lenient"} : std::vector<std::string>{});
      EXPECT_EQ(result.status, lenient ? 0 : 3) << result.err;
      EXPECT_EQ(read_exr(image_).width, 64);
      for (const float value : read_exr(image_).data) ASSERT_TRUE(std::isfinite(value));
      if (!who.empty()) {
        EXPECT_NE(result.err.find("plugin " + who + " is at fault: a"), std::string::npos)
            << result.err;
      }
      EXPECT_NE(result.err.find(what), std::string::npos) << result.err;
      fs::remove(image_);
    }
  };
  // A status of 3 is never without its reason.
  const ProcessResult quiet = run(faulty("bsdf", "nan"), sky_, direct_, {"-q"});
  EXPECT_EQ(quiet.status, 3);
  EXPECT_NE(quiet.err.find("plugin bsdf/faulty is at fault"), std::string::npos) << quiet.err;
  const ProcessResult lenient = run(faulty("bsdf", "nan"), sky_, direct_, {"-q", "--lenient"});
  EXPECT_EQ(lenient.status, 0);
  EXPECT_EQ(lenient.err, "");
  for (const char* integrator : {"direct", "path", "ptracer", "clustered"}) {
    SCOPED_TRACE(integrator);
    const std::string xml = "<integrator type=\"" + std::string(integrator) + "\"/>";
    expect_fault(faulty("bsdf", "nan"), sky_, xml, "bsdf/faulty", "not finite");
    expect_fault(faulty("bsdf", "negative pdf", "id=\"mine\""), sky_, xml, "bsdf/faulty 'mine'",
                 "a density that is negative");
    // Whatever it is nested in is not to blame.
    expect_fault("<bsdf type=\"twosided\">" + faulty("bsdf", "nan") + "</bsdf>", sky_, xml,
                 "bsdf/faulty", "not finite");
  }
  const std::string textured =
      "<bsdf type=\"diffuse\">" + faulty("texture", "nan", "name=\"reflectance\"") + "</bsdf>";
  expect_fault(textured, sky_, direct_, "texture/faulty", "not finite");
  expect_fault("", faulty("emitter", "nan"), direct_, "emitter/faulty", "not finite");
  expect_fault("", faulty("emitter", "negative pdf"), direct_, "emitter/faulty", "negative");
  expect_fault("", sky_, faulty("integrator", "nan"), "", "samples that were not finite");
}

/// All values are finite and no density is negative, but they don't fit together: the picture is
/// wrong, if only by 2 %.
TEST_F(FaultyPlugins, ThatContradictThemselvesAreNamed) {
  const auto expect_fault = [&](const ProcessResult& result, const std::string& what) {
    EXPECT_EQ(result.status, 3) << result.err;
    EXPECT_NE(result.err.find("/faulty is at fault: " + what + ", at "), std::string::npos)
        << "no '" << what << "' in " << result.err;
    // And that the picture is written; what is wrong in two ways may be told twice.
    EXPECT_LE(lines(result.err), 3u) << result.err;
  };
  const std::pair<const char*, const char*> of_skies[] = {
      {"pdf", "a density from sample_direct() that is not pdf_environment()'s"},
      {"radiance", "a radiance from sample_direct() that is not eval_environment()'s"},
      {"length", "a direction that is not of unit length"},
      {"half", "a density that its samples don't follow"},
      {"twice", "a density that its samples don't follow"},
      {"no pdf", "a density of 0 where there is light"},
      {"batch",
       "an eval_environment_batch() that is not eval_environment() and"
       " pdf_environment()"},
      {"grid", "a cell_grid() whose radiance is not eval_environment()'s"},
      {"corners", "a cell_grid() whose radiance is not eval_environment()'s"},
      {"bilinear", "a cell_grid() whose quads are not bilinear as it says"},
      {"edges", "a cell_grid() whose quads are not smooth as it says"},
  };
  for (const auto& [fault, what] : of_skies) {
    SCOPED_TRACE(fault);
    expect_fault(run("", faulty("emitter", fault), direct_), what);
  }
  const std::pair<const char*, const char*> of_lamps[] = {
      {"lamp pdf", "a density from sample_direct() that is not pdf_surface()'s"},
      {"lamp radiance", "a radiance from sample_direct() that is not eval_surface()'s"},
      {"lamp aim", "a direction from sample_direct() that misses its shape"},
      {"lamp delta", "a density of a delta light that is not 1"},
  };
  for (const auto& [fault, what] : of_lamps) {
    SCOPED_TRACE(fault);
    expect_fault(run("", lamp(faulty("emitter", fault)), direct_), what);
  }
  const std::pair<const char*, const char*> of_bsdfs[] = {
      {"pdf", "a density from sample() that is not eval_pdf()'s"},
      {"weight", "a weight from sample() that is not eval_pdf()'s f / pdf"},
      {"length", "a direction that is not of unit length"},
      {"half", "a density that its samples don't follow"},
      {"no pdf", "a density of 0 where there is light"},
  };
  for (const auto& [fault, what] : of_bsdfs) {
    SCOPED_TRACE(fault);
    expect_fault(run(faulty("bsdf", fault), sky_, direct_), what);
    // Whatever it is nested in is not to blame.
    expect_fault(run("<bsdf type=\"twosided\">" + faulty("bsdf", fault) + "</bsdf>", sky_, direct_),
                 what);
  }
}

TEST_F(FaultyPlugins, SoundOnesAreNotBlamed) {
  const ProcessResult lit =
      run(faulty("bsdf", "none"), lamp(faulty("emitter", "lamp")), faulty("integrator", "none"));
  EXPECT_EQ(lit.status, 0) << lit.err;
  const ProcessResult result =
      run(faulty("bsdf", "none"), faulty("emitter", "none"), faulty("integrator", "none"));
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err.find("fault:"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace kinome::test
