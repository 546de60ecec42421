/// Tests that a resumed render has the same bits as an uninterrupted one.
#include "kinome/checkpoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/render.h"
#include "support/sanitizer.h"

namespace kinome::test::checkpoint_test {
namespace {

namespace fs = std::filesystem;

std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

/// The filter reaches into neighbouring tiles, so that the order of tiles matters.
std::unique_ptr<Scene> scene_with(const std::string& integrator, int samples = 4, int width = 70) {
  return scene_from(integrator + R"(
    <emitter type="constant"/>
    <sensor type="perspective">
      <transform name="to_world"><lookat origin="0 2 4" target="0 .5 0" up="0 1 0"/></transform>
      <sampler type="independent"><integer name="sample_count" value=")" +
                    std::to_string(samples) + R"("/></sampler>
      <film type="hdrfilm">
        <integer name="width" value=")" +
                    std::to_string(width) + R"("/> <integer name="height" value="34"/>
        <string name="pixel_format" value="rgba"/> <boolean name="sample_border" value="true"/>
        <rfilter type="gaussian"/>
      </film>
    </sensor>
    <shape type="sphere"><point name="center" value="0 1 0"/>
      <bsdf type="roughplastic"/></shape>
    <shape type="rectangle">
      <transform name="to_world"><rotate x="1" angle="-90"/> <scale value="3"/></transform>
    </shape>)");
}

/// A render that can be cancelled after a number of progress calls.
struct Interruptible {
  unsigned threads = 1;
  RenderBudget budget = {};
  int cancel_at = 0;                               ///< number of the call that cancels; 0: never
  std::function<void(int)> on_progress = nullptr;  ///< called with the number of each call
  int calls = 0;

  Image render(const Scene& scene, Checkpoint* checkpoint) {
    std::atomic<bool> cancel{false};
    calls = 0;
    RenderContext context({.threads = threads,
                           .seed = 5,
                           .cancel = &cancel,
                           .progress =
                               [&](double) {
                                 ++calls;
                                 if (on_progress) on_progress(calls);
                                 if (calls == cancel_at) cancel = true;
                               },
                           .budget = budget});
    context.job.set_work_source(checkpoint);
    return kinome::render(scene, *scene.sensors()[0], context);
  }
};

class Resuming : public ::testing::Test {
 protected:
  Checkpoint::Options options(bool resume) const { return {folder_.path("c"), 0, resume}; }

  /// Cancels the render at several points. Also copies the checkpoint earlier, as if the program
  /// had been killed then.
  void expect_same_bits(const Scene& scene, const RenderBudget& budget = {}) {
    Interruptible whole{.threads = 2, .budget = budget};
    const std::vector<float> expected = whole.render(scene, nullptr).data;
    Interruptible counted{.budget = budget};
    counted.render(scene, nullptr);
    std::vector<int> places{1, counted.calls / 3, counted.calls * 2 / 3, counted.calls - 1};
    if (kHasSanitizer) places = {counted.calls / 3};
    for (const int at : places) {
      SCOPED_TRACE(at);
      const std::string copy = folder_.path("copy");
      {
        Checkpoint checkpoint(options(false));
        Interruptible run{.budget = budget, .cancel_at = at, .on_progress = [&](int call) {
                            std::error_code none_yet;
                            if (call == (at + 1) / 2)
                              fs::copy_file(folder_.path("c"), copy, none_yet);
                          }};
        run.render(scene, &checkpoint);
      }
      for (const unsigned threads : {3u, 1u}) {
        Checkpoint checkpoint(options(true));
        EXPECT_TRUE(checkpoint.resumes());
        Interruptible run{.threads = threads, .budget = budget};
        EXPECT_EQ(run.render(scene, &checkpoint).data, expected) << threads;
        if (!fs::exists(copy)) break;
        fs::rename(copy, folder_.path("c"));
      }
      fs::remove(folder_.path("c"));
    }
  }

  TemporaryFolder folder_;
};

TEST_F(Resuming, EveryIntegratorGivesTheSameBits) {
  for (const char* integrator :
       {R"(<integrator type="direct"/>)", R"(<integrator type="path"/>)",
        R"(<integrator type="depth"/>)", R"(<integrator type="ptracer"/>)",
        R"(<integrator type="aov"><string name="aovs" value="n:sh_normal"/>
             <integrator type="ptracer"/></integrator>)",
        R"(<integrator type="groundtruth"><integer name="light_samples" value="32"/>
             <integer name="max_depth" value="2"/></integrator>)",
        R"(<integrator type="clustered"><string name="importance" value="joint"/>
             <integer name="max_depth" value="3"/> <integer name="light_samples" value="256"/>
             <integer name="cut_size" value="16"/> <integer name="emitter_samples" value="8"/>
             <integer name="brdf_samples" value="4"/></integrator>)",
        R"(<integrator type="clustered"><boolean name="diagnostics" value="true"/>
             <integer name="max_depth" value="2"/></integrator>)"}) {
    SCOPED_TRACE(integrator);
    expect_same_bits(*scene_with(integrator));
  }
}

/// Renders several passes over the image: of samples, and of rays.
TEST_F(Resuming, PassesGiveTheSameBits) {
  expect_same_bits(*scene_with(R"(<integrator type="depth"/>)", 1030, 4));
  expect_same_bits(*scene_with(R"(<integrator type="clustered">
      <float name="rays_per_pixel" value="1100"/><integer name="cut_size" value="16"/>
      <integer name="max_depth" value="2"/></integrator>)",
                               4, 4));
}

/// The rounds of a budget depend on the samples so far.
TEST_F(Resuming, BudgetsGiveTheSameBits) {
  const auto scene = [](const std::string& integrator, const std::string& parameters = "") {
    return scene_with("<integrator type='" + integrator + "'>" + parameters + "</integrator>", 4,
                      30);
  };
  expect_same_bits(*scene("direct"), {.rel_mse = 0.1});
  expect_same_bits(*scene("clustered", R"(<integer name="max_depth" value="2"/>)"),
                   {.rel_mse = 0.1});
  expect_same_bits(*scene("ptracer"), {.lanes = 4});
}

/// A complete render whose image could not be written is not rendered again.
TEST_F(Resuming, WholeRendersAreNotRepeated) {
  const auto scene = scene_with(R"(<integrator type="direct"/>)");
  Checkpoint first(options(false));
  Interruptible run;
  const Image image = run.render(*scene, &first);
  first.close(scene->sensors()[0]->film());
  Checkpoint second(options(true));
  Interruptible again;
  EXPECT_EQ(again.render(*scene, &second).data, image.data);
  EXPECT_EQ(again.calls, 0);
  second.remove();
  EXPECT_FALSE(fs::exists(folder_.path("c")));
}

TEST_F(Resuming, WithoutAFileStartsAnew) {
  const auto scene = scene_with(R"(<integrator type="direct"/>)");
  Checkpoint checkpoint(options(true));
  EXPECT_FALSE(checkpoint.resumes());
  Interruptible with, without;
  EXPECT_EQ(with.render(*scene, &checkpoint).data, without.render(*scene, nullptr).data);
}

/// Failures to write checkpoints cause one warning, and the render completes.
TEST_F(Resuming, FailedCheckpointsAreOneWarning) {
  const auto scene = scene_with(R"(<integrator type="direct"/>)");
  Interruptible whole;
  const std::vector<float> expected = whole.render(*scene, nullptr).data;
  const struct {
    const char* name;
    std::function<void(const fs::path& folder)> spoil;
  } cases[] = {{"gone", [](const fs::path& folder) { fs::remove_all(folder); }},
               {"a loop", [](const fs::path& folder) {
                  fs::remove_all(folder);
                  fs::create_directory_symlink(folder.filename(), folder);
                }}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const fs::path place = folder_.path("place");
    fs::remove(place);
    fs::create_directory(place);
    Checkpoint checkpoint({(place / "c").string(), 0, false});
    c.spoil(place);
    Interruptible run;
    testing::internal::CaptureStderr();
    EXPECT_EQ(run.render(*scene, &checkpoint).data, expected);
    checkpoint.close(scene->sensors()[0]->film());
    const std::string log = testing::internal::GetCapturedStderr();
    EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
    EXPECT_NE(log.find("the render continues without it"), std::string::npos) << log;
  }
}

TEST_F(Resuming, IsAnnouncedOnceItIsAccepted) {
  const auto scene = scene_with(R"(<integrator type="direct"/>)");
  {
    Checkpoint checkpoint(options(false));
    Interruptible run{.cancel_at = 4};
    run.render(*scene, &checkpoint);
  }
  int announced = 0;
  Checkpoint::Options resuming = options(true);
  resuming.on_resume = [&] { ++announced; };
  Checkpoint foreign(resuming);
  foreign.set_identity({{Checkpoint::kScene, "0123456789abcdef"}});
  Interruptible run;
  try {
    run.render(*scene, &foreign);
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(error.message().find("its scene has changed"), std::string::npos) << error.what();
    EXPECT_EQ(error.message().find("0123456789"), std::string::npos) << error.what();
  }
  EXPECT_EQ(announced, 0);
  Checkpoint same(resuming);
  run.render(*scene, &same);
  EXPECT_EQ(announced, 1);
}

class Refused : public Resuming {
 protected:
  Refused() : scene_(scene_with(R"(<integrator type="direct"/>)")) {
    Checkpoint checkpoint(options(false));
    checkpoint.set_identity({{"seed", "5"}});
    Interruptible run{.cancel_at = 4};
    run.render(*scene_, &checkpoint);
    bytes_ = read_bytes(folder_.path("c"));
  }
  /// Returns the error message for a checkpoint file with these bytes.
  std::string error_of(const std::string& bytes, const Checkpoint::Identity& identity) {
    folder_.write("c", bytes);
    try {
      Checkpoint checkpoint(options(true));
      checkpoint.set_identity(identity);
      Interruptible run;
      run.render(*scene_, &checkpoint);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }

  std::unique_ptr<Scene> scene_;
  std::string bytes_;
};

TEST_F(Refused, DamagedAnywhere) {
  const Checkpoint::Identity identity = {{"seed", "5"}};
  EXPECT_EQ(error_of(bytes_, identity), "none");
  const std::string prefix = "checkpoint '" + folder_.path("c") + "': it is ";
  for (size_t size = 0; size < bytes_.size(); size += 1 + size / 3) {
    const std::string error = error_of(bytes_.substr(0, size), identity);
    EXPECT_EQ(error.rfind(prefix, 0), 0u) << size << ": " << error;
  }
  EXPECT_NE(error_of(bytes_ + "x", identity), "none");
  for (size_t at = 0; at < bytes_.size(); at += 1 + at / 5) {
    std::string damaged = bytes_;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    EXPECT_NE(error_of(damaged, identity), "none") << at;
  }
}

TEST_F(Refused, ForeignOnes) {
  EXPECT_NE(error_of("This is a shopping list.", {}).find("not a checkpoint"), std::string::npos);
  const std::string other = error_of(bytes_, {{"seed", "6"}});
  EXPECT_NE(other.find("another render: its seed is '5', expected '6'"), std::string::npos)
      << other;
  const std::string none = error_of(bytes_, {});
  EXPECT_NE(none.find("its seed is '5', expected not given"), std::string::npos) << none;
  scene_ = scene_with(R"(<integrator type="aov"><string name="aovs" value="n:sh_normal"/>
                           <integrator type="direct"/></integrator>)");
  const std::string film = error_of(bytes_, {{"seed", "5"}});
  EXPECT_NE(film.find("it belongs to another render"), std::string::npos) << film;
}

TEST_F(Refused, OneThatWouldBeOverwritten) {
  try {
    const Checkpoint checkpoint(options(false));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("it exists"), std::string::npos) << error.what();
  }
  EXPECT_EQ(read_bytes(folder_.path("c")), bytes_);
}

}  // namespace
}  // namespace kinome::test::checkpoint_test
