// Tests of plugins that throw, crash, or return invalid values: one line names them, and the exit
// status shows the failure.

#include <csignal>
#include <cstdlib>
#include <tuple>

#include "cli.h"
#include "kinome/image_files.h"
#include "kinome/image.h"
#include "kinome/instruction_set.h"

namespace kinome::test::faulty_plugins_test {
namespace {

namespace fs = std::filesystem;

class FaultyPlugins : public Cli {
 protected:
  /// Renders a scene with the given sphere, sky and integrator.
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
  /// A square above the scene that emits downward.
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

  std::string scene_;
  const std::string image_ = folder_.path("a.exr");
  const std::string sky_ = R"(<emitter type="constant"/>)";
  const std::string direct_ = R"(<integrator type="direct"/>)";
};

TEST_F(FaultyPlugins, ThatThrowAreNamed) {
  // In construction, with its position.
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
  // Within Embree.
  for (const char* fault : {"bounds", "intersect", "interaction"}) {
    SCOPED_TRACE(fault);
    expect_failure(run("", sky_ + faulty("shape", fault), direct_),
                   {"plugin 'shape/faulty' failed: can't be"});
  }
}

#ifndef KINOME_HAS_SANITIZER  // they report crashes themselves
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
  // The innermost active plugin is named, also within Embree.
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
  // A crash in the core that a plugin called may also be the plugin's fault.
  expect_crash(run("", sky_, faulty("integrator", "crash in the core")), SIGSEGV,
               "crashed (SIGSEGV) while rendering, called by plugin 'integrator/faulty'");
  // A crash while loading, when only the name is known.
  const std::string textured =
      "<bsdf type=\"diffuse\">" + faulty("texture", "none", "name=\"reflectance\"") + "</bsdf>";
  setenv("KINOME_TEST_CRASH", "1", 1);
  expect_crash(run(textured, sky_, direct_), SIGSEGV,
               "plugin 'texture/faulty'" + segv + "loading the scene");
  unsetenv("KINOME_TEST_CRASH");
}
#endif

/// Faulty values are never ignored silently. The image is written, the plugin named, its faults
/// counted, and the exit status is 3 by default.
TEST_F(FaultyPlugins, WithInvalidValuesAreNamedAndCounted) {
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
  // A status of 3 always has a message.
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
    // The enclosing plugin is not named.
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

/// All values are finite and no density is negative, but they are inconsistent: the image is wrong,
/// if only by 2 %.
TEST_F(FaultyPlugins, ThatContradictThemselvesAreNamed) {
  const auto expect_fault = [&](const ProcessResult& result, const std::string& what) {
    EXPECT_EQ(result.status, 3) << result.err;
    EXPECT_NE(result.err.find("/faulty is at fault: " + what + ", at "), std::string::npos)
        << "no '" << what << "' in " << result.err;
    // One line reports the image; an inconsistency may be reported twice.
    EXPECT_LE(lines(result.err), 3u) << result.err;
  };
  const std::pair<const char*, const char*> of_skies[] = {
      {"pdf", "a density from sample_direct() that differs from pdf_environment()"},
      {"radiance", "a radiance from sample_direct() that differs from eval_environment()"},
      {"length", "a direction that is not of unit length"},
      {"half", "a density that its samples don't follow"},
      {"twice", "a density that its samples don't follow"},
      {"no pdf", "a density of 0 where the value is not 0"},
      {"batch",
       "a value from eval_environment_batch() that differs from eval_environment() or"
       " pdf_environment()"},
      {"block", "a sample from sample_direct_block() that differs from sample_direct()"},
      {"grid", "a cell_grid() whose radiance differs from eval_environment()"},
      {"corners", "a cell_grid() whose radiance differs from eval_environment()"},
      {"bilinear", "a cell_grid() with bilinear_quads whose quads are not bilinear"},
      {"edges", "a cell_grid() with smooth_quads whose quads are not smooth"},
  };
  for (const auto& [fault, what] : of_skies) {
    SCOPED_TRACE(fault);
    expect_fault(run("", faulty("emitter", fault), direct_), what);
  }
  const std::pair<const char*, const char*> of_lamps[] = {
      {"lamp pdf", "a density from sample_direct() that differs from pdf_surface()"},
      {"lamp radiance", "a radiance from sample_direct() that differs from eval_surface()"},
      {"lamp aim", "a direction from sample_direct() that misses its shape"},
      {"lamp delta", "a density of a delta light that is not 1"},
  };
  for (const auto& [fault, what] : of_lamps) {
    SCOPED_TRACE(fault);
    expect_fault(run("", lamp(faulty("emitter", fault)), direct_), what);
  }
  const std::pair<const char*, const char*> of_bsdfs[] = {
      {"pdf", "a density from sample() that differs from eval_pdf()"},
      {"weight", "a weight from sample() that differs from f / pdf of eval_pdf()"},
      {"length", "a direction that is not of unit length"},
      {"half", "a density that its samples don't follow"},
      {"no pdf", "a density of 0 where the value is not 0"},
  };
  for (const auto& [fault, what] : of_bsdfs) {
    SCOPED_TRACE(fault);
    expect_fault(run(faulty("bsdf", fault), sky_, direct_), what);
    // The enclosing plugin is not named.
    expect_fault(run("<bsdf type=\"twosided\">" + faulty("bsdf", fault) + "</bsdf>", sky_, direct_),
                 what);
  }
}

/// A library for AVX-512 is in the place of one for less, or requires features that no processor
/// has. It is reported once, though the floor has the same BSDF.
TEST_F(FaultyPlugins, OfABetterProcessorAreRefused) {
  const std::string least = to_string(min_instruction_set());
  if (least.rfind("x86-64-v", 0) != 0) GTEST_SKIP() << "the sets have no numbers to change";
  const fs::path better = fs::path(KINOME_TEST_PLUGINS) / "bsdf/x86-64-v4/diffuse.so";
  const bool has_better = fs::exists(better);
  std::ifstream file(has_better ? better : fs::path(KINOME_TEST_PLUGINS) / "bsdf/diffuse.so",
                     std::ios::binary);
  const std::string library{std::istreambuf_iterator<char>(file), {}};
  const std::string key = ";isa=" + (has_better ? "x86-64-v4" : least) + ";";
  std::string unknown = library;
  size_t changed = 0;
  for (size_t at = unknown.find(key); at != std::string::npos; at = unknown.find(key, at)) {
    unknown[at + key.size() - 2] = '9';
    ++changed;
  }
  ASSERT_GT(changed, 0u);
  const bool is_here = processor_instruction_set() == InstructionSet::kX86V4;
  const struct {
    const std::string& bytes;
    std::string what;
  } cases[] = {
      {unknown, "x86-64-v9, which this processor lacks"},
      {library, is_here ? "x86-64-v4, but the best one allowed is " + least
                        : "x86-64-v4, which this processor lacks"},
  };
  for (const auto& c : cases) {
    if (&c.bytes == &library && !has_better) continue;  // the program may use it
    const std::string other = folder_.write("plugins/bsdf/diffuse.so", c.bytes);
    const ProcessResult result = run("<bsdf type=\"diffuse\"/>", sky_, direct_,
                                     {"--plugin-path", folder_.path("plugins"), "--isa", least});
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.err, "kinome: " + scene_ + ":10:66: '" + other +
                              "' is not a usable plugin: it is built for the instruction set " +
                              c.what + "\n");
    EXPECT_FALSE(fs::exists(image_));
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
}  // namespace kinome::test::faulty_plugins_test
