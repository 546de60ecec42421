/// Tests that the merged parts of an image have the bits of the whole image.
#include "kinome/image_files.h"
#include "kinome/parts.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "support/render.h"

namespace kinome::test::parts_test {
namespace {

constexpr uint64_t kSeed = 3;

/// The filter reaches into neighbouring pixels, and its weights cause rounded sums.
std::unique_ptr<Scene> scene_with(const std::string& integrator, const std::string& film = "") {
  return scene_from(integrator + R"(
    <emitter type="constant"/>
    <sensor type="perspective">
      <transform name="to_world"><lookat origin="0 2 4" target="0 .5 0" up="0 1 0"/></transform>
      <sampler type="independent"><integer name="sample_count" value="8"/></sampler>
      <film type="hdrfilm">
        <integer name="width" value="40"/> <integer name="height" value="34"/>
        <integer name="crop_offset_x" value="3"/> <integer name="crop_width" value="35"/>
        <string name="component_format" value="float32"/> <rfilter type="gaussian"/>)" +
                    film + R"(
      </film>
    </sensor>
    <shape type="sphere"><point name="center" value="0 1 0"/>
      <bsdf type="roughplastic"/></shape>
    <shape type="rectangle">
      <transform name="to_world"><rotate x="1" angle="-90"/> <scale value="3"/></transform>
      <emitter type="area"/>
    </shape>)");
}

/// Returns all sums of a film.
std::vector<std::vector<double>> sums_in(Film& film) {
  std::vector<std::vector<double>> sums;
  film.transfer([&](void* bytes, size_t count) {
    if (count % sizeof(double) != 0) return;
    sums.emplace_back(count / sizeof(double));
    std::memcpy(sums.back().data(), bytes, count);
  });
  return sums;
}

class Parts : public ::testing::Test {
 protected:
  RenderContext context(const std::atomic<bool>* cancel = nullptr, uint64_t seed = kSeed) const {
    return RenderContext({.threads = 2, .seed = seed, .cancel = cancel});
  }
  ImageMetadata metadata(uint64_t seed = kSeed) const {
    return {{"kinome:version", "1"},
            {"kinome:scene", "s.xml"},
            {"kinome:scene_hash", "5"},
            {"kinome:samples", "3"},
            {"kinome:seed", std::to_string(seed)},
            {"kinome:complete", "true"}};
  }
  /// Renders part i of n, counted from 1, and returns the name of its file.
  std::string part(const Scene& scene, uint32_t i, uint32_t n, uint64_t seed = kSeed) {
    const PartRender part(scene, *scene.sensors()[0], {i - 1, n});
    RenderContext own = context(nullptr, seed);
    images_.push_back(part.render(own));
    const std::string path =
        folder_.path(std::to_string(i) + "of" + std::to_string(n) + "-" + std::to_string(seed));
    part.write(path + ".exr", images_.back(), metadata(seed));
    return path + ".exr";
  }
  MergedParts merge(const std::vector<std::string>& paths, bool allows_missing = false) const {
    return merge_parts(paths, allows_missing, registry());
  }
  void expect_refused(const std::vector<std::string>& paths, const std::string& why,
                      bool allows_missing = false) const {
    try {
      merge(paths, allows_missing);
      FAIL() << "merged, though " << why;
    } catch (const Error& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find(why), std::string::npos) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    }
  }

  TemporaryFolder folder_;
  std::vector<Image> images_;  ///< of the parts
};

/// Tests all contents of films: light paths, layers, powers, alpha, luminance.
TEST_F(Parts, MergedHaveTheBitsOfTheWhole) {
  const struct {
    const char* integrator;
    const char* film;
  } cases[] = {
      {R"(<integrator type="path"/>)", R"(<string name="pixel_format" value="rgba"/>)"},
      {R"(<integrator type="ptracer"/>)", R"(<string name="pixel_format" value="xyz"/>)"},
      {R"(<integrator type="clustered"><integer name="max_depth" value="2"/></integrator>)",
       R"(<string name="pixel_format" value="luminance"/>)"},
      {R"(<integrator type="clustered"><boolean name="diagnostics" value="true"/></integrator>)",
       ""},
      {R"(<integrator type="aov"><string name="aovs" value="n:sh_normal"/>
            <integrator type="path"/> <integrator type="ptracer"/></integrator>)",
       R"(<string name="pixel_format" value="luminance_alpha"/>)"},
      {R"(<integrator type="moment"><integrator type="path"/></integrator>)",
       R"(<boolean name="sample_border" value="true"/>)"}};
  for (const auto& [integrator, film] : cases) {
    SCOPED_TRACE(integrator);
    const auto scene = scene_with(integrator, film);
    RenderContext own = context();
    const Image whole = render_all_parts(*scene, *scene->sensors()[0], own, 3);
    EXPECT_EQ(own.job.stats().samples, 9);
    const MergedParts merged = merge({part(*scene, 3, 3), part(*scene, 1, 3), part(*scene, 2, 3)});
    EXPECT_EQ(merged.image.channels, whole.channels);
    EXPECT_EQ(merged.image.data, whole.data);
    EXPECT_EQ(merged.count, 3u);
    EXPECT_EQ(merged.metadata.at("kinome:samples"), "9");
    EXPECT_EQ(merged.metadata.at("kinome:complete"), "true");
    // Parts must have independent noise.
    EXPECT_NE(images_[images_.size() - 1].data, images_[images_.size() - 2].data);
    // The files must be equal to those of the film.
    merged.film->write(folder_.path("merged.exr"), merged.image, merged.metadata);
    scene->sensors()[0]->film().write(folder_.path("whole.exr"), whole, merged.metadata);
    const auto bytes = [&](const std::string& name) {
      std::ifstream file(folder_.path(name), std::ios::binary);
      return std::string(std::istreambuf_iterator<char>(file), {});
    };
    EXPECT_EQ(bytes("merged.exr"), bytes("whole.exr"));
  }
}

/// Parts are the lanes from which the noise is estimated.
TEST_F(Parts, NoiseEqualsThatOfIndependentRenders) {
  const auto scene = scene_with(R"(<integrator type="path"/>)");
  RenderContext own({.threads = 2, .seed = kSeed, .budget = {.lanes = 3}});
  const Image whole = render_all_parts(*scene, *scene->sensors()[0], own, 3);
  const std::vector<std::string> paths = {part(*scene, 1, 3), part(*scene, 2, 3),
                                          part(*scene, 3, 3)};
  const MergedParts merged = merge_parts(paths, false, registry(), true);
  EXPECT_GE(merged.image.find_channel("variance.R"), 0);
  EXPECT_EQ(merged.image.channels, whole.channels);
  EXPECT_EQ(merged.image.data, whole.data);
  // A single part has no noise estimate.
  EXPECT_LT(merge_parts({paths[0]}, true, registry(), true).image.find_channel("variance.R"), 0);
}

/// Another order of the additions would be rounded differently. Images in single precision seldom
/// show the difference, so this test compares the sums.
TEST_F(Parts, AreAddedInTheirOrder) {
  const auto scene = scene_with(R"(<integrator type="ptracer"/>)");
  std::vector<std::string> paths;
  std::vector<std::vector<std::vector<double>>> of_parts;
  for (uint32_t i = 1; i <= 3; ++i) {
    paths.push_back(part(*scene, i, 3));
    of_parts.push_back(sums_in(*merge({paths.back()}, true).film));
  }
  size_t by_order = 0;
  for (const std::vector<int>& order : {std::vector{0, 1, 2}, {2, 1, 0}, {1, 0, 2}}) {
    const MergedParts merged = merge({paths[order[0]], paths[order[1]], paths[order[2]]});
    const auto sums = sums_in(*merged.film);
    for (size_t s = 0; s < sums.size(); ++s) {
      if (sums[s].size() < 2) continue;  // a count of samples
      for (size_t i = 0; i < sums[s].size(); ++i) {
        const double a = of_parts[0][s][i], b = of_parts[1][s][i], c = of_parts[2][s][i];
        ASSERT_EQ(sums[s][i], (a + b) + c);
        by_order += (a + b) + c != (c + b) + a;
      }
    }
  }
  EXPECT_GT(by_order, 0u);
}

/// The image is the mean of the available parts, and its metadata has their number of samples.
TEST_F(Parts, MissingOnesAreLeftOutOfTheMean) {
  for (const char* integrator :
       {R"(<integrator type="path"/>)", R"(<integrator type="ptracer"/>)"}) {
    SCOPED_TRACE(integrator);
    const auto scene = scene_with(integrator);
    images_.clear();
    const std::vector<std::string> paths = {part(*scene, 4, 5), part(*scene, 2, 5)};
    expect_refused(paths, "parts 1, 3 and 5 of 5 are missing: add --allow-missing");
    const MergedParts merged = merge(paths, true);
    EXPECT_EQ(merged.missing, (std::vector<uint32_t>{1, 3, 5}));
    EXPECT_EQ(merged.metadata.at("kinome:missing_parts"), "1, 3 and 5");
    EXPECT_EQ(merged.metadata.at("kinome:complete"), "false");
    EXPECT_EQ(merged.metadata.at("kinome:samples"), "6");  // 3 samples in each of 2 parts
    EXPECT_EQ(merged.gaps, 0);
    double difference = 0, sum = 0;
    for (size_t i = 0; i < merged.image.data.size(); ++i) {
      const double mean = 0.5 * (images_[0].data[i] + images_[1].data[i]);
      // Weights of pixels depend on the positions of samples; those of light paths don't.
      difference += std::abs(mean - merged.image.data[i]);
      sum += std::abs(mean);
    }
    const bool is_by_paths = std::string(integrator).find("ptracer") != std::string::npos;
    EXPECT_LT(difference, (is_by_paths ? 1e-6 : 0.1) * sum);
  }
}

TEST_F(Parts, InterruptedPartsCountWithTheirSamples) {
  const auto scene = scene_with(R"(<integrator type="path"/>)");
  const std::string whole = part(*scene, 1, 2);
  const PartRender second(*scene, *scene->sensors()[0], {1, 2});
  std::atomic<bool> cancel{false};
  RenderContext own(
      {.threads = 1, .seed = kSeed, .cancel = &cancel, .progress = [&](double) { cancel = true; }});
  const Image image = second.render(own);
  EXPECT_GT(own.job.stats().missing, 0.01);
  EXPECT_EQ(own.job.stats().filled, 0);
  ImageMetadata says = metadata();
  says["kinome:complete"] = "false";
  const std::string path = folder_.path("interrupted.exr");
  second.write(path, image, says);
  expect_refused({whole, path}, "part 2 of 2 is incomplete");
  const MergedParts both = merge({path, whole}, true), first = merge({whole}, true),
                    last = merge({path}, true);
  EXPECT_EQ(both.metadata.at("kinome:incomplete_parts"), "2");
  EXPECT_EQ(both.gaps, 0);
  EXPECT_GT(last.gaps, 0.01);
  EXPECT_EQ(last.image.channels.back(), "A");
  // Pixels without samples in the second part have the values of the first part.
  size_t equal = 0, others = 0;
  for (size_t p = 0; p < last.image.data.size() / 4; ++p) {
    const bool is_same =
        std::equal(&both.image.data[3 * p], &both.image.data[3 * p] + 3, &first.image.data[3 * p]);
    EXPECT_TRUE(is_same || last.image.data[4 * p + 3] != 0);
    (is_same ? equal : others) += 1;
  }
  EXPECT_GT(equal, 9u);
  EXPECT_GT(others, 9u);
}

TEST_F(Parts, OthersAreRefusedByName) {
  const auto scene = scene_with(R"(<integrator type="path"/>)");
  const std::string a = part(*scene, 1, 2), b = part(*scene, 2, 2);
  const std::string copy = folder_.path("copy.exr");
  std::filesystem::copy_file(a, copy);
  expect_refused({a, b, copy}, "copy.exr: it is part 1 of 2, and so is " + a);
  expect_refused({a, a}, "1of2-3.exr: it is given twice", true);
  expect_refused({a, part(*scene, 2, 2, 4)}, "its seed is 4, expected 3");
  expect_refused({a, part(*scene, 3, 3)}, "its number of parts is 3, expected 2", true);
  const auto other =
      scene_with(R"(<integrator type="path"/>)", R"(<string name="pixel_format" value="rgba"/>)");
  expect_refused({a, part(*other, 2, 2, kSeed)}, "its format is rgba float32");
  expect_refused({}, "no parts to merge");
}

/// Machines with other instruction sets render slightly different parts, which can be merged.
TEST_F(Parts, OfSeveralInstructionSetsAreMerged) {
  const auto scene = scene_with(R"(<integrator type="path"/>)");
  std::vector<std::string> paths;
  for (uint32_t i = 0; i < 3; ++i) {
    const PartRender part(*scene, *scene->sensors()[0], {i, 3});
    RenderContext own = context();
    ImageMetadata says = metadata();
    says["kinome:isa"] = i == 1 ? "old" : "new";
    paths.push_back(folder_.path(std::to_string(i) + ".exr"));
    part.write(paths.back(), part.render(own), says);
  }
  const MergedParts merged = merge(paths);
  EXPECT_TRUE(merged.is_mixed);
  EXPECT_EQ(merged.metadata.at("kinome:isa"), "new old");
  EXPECT_FALSE(merge({paths[2], paths[0]}, true).is_mixed);
}

/// Truncated files, and files with a changed byte.
TEST_F(Parts, DamagedOnesAreOneClearError) {
  const auto scene = scene_with(R"(<integrator type="ptracer"/>)");
  const std::string path = part(*scene, 1, 1);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  const std::vector<float> expected = merge({path}).image.data;
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    const size_t at = bytes.size() * i / 60;
    expect_refused({folder_.write("cut.exr", bytes.substr(0, at))}, "cut.exr: ");
    std::string changed = bytes;
    changed[at + 7] = static_cast<char>(changed[at + 7] ^ 0x10);
    const std::string damaged = folder_.write("damaged.exr", changed);
    // Changes in the first image of the file don't affect the parts.
    try {
      EXPECT_EQ(merge({damaged}).image.data, expected);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("damaged.exr: "), std::string::npos) << error.what();
    }
  }
  write_exr(folder_.path("picture.exr"), images_.back(), ExrSampleType::kFloat, metadata());
  expect_refused({folder_.path("picture.exr")}, "it is an image, but not a part");
  expect_refused({folder_.path("none.exr")}, "no such file");
}

TEST_F(Parts, OfFilmsThatCantBeMergedAreRefused) {
  const auto scene =
      scene_with(R"(<integrator type="path"/>)", R"(<string name="file_format" value="pfm"/>)");
  EXPECT_THROW(PartRender(*scene, *scene->sensors()[0], {0, 2}), Error);
}

/// An irradiance meter measures π for any colour format of the film.
TEST_F(Parts, ContainTheSensorsResponse) {
  const auto scene = scene_from(R"(
    <emitter type="constant"/>
    <shape type="rectangle">
      <sensor type="irradiancemeter">
        <sampler type="independent"><integer name="sample_count" value="9"/></sampler>
        <film type="hdrfilm"> <integer name="width" value="2"/> <integer name="height" value="2"/>
          <string name="pixel_format" value="luminance"/> <rfilter type="box"/> </film>
      </sensor>
    </shape>)");
  RenderContext own = context();
  const Image whole = render_all_parts(*scene, *scene->sensors()[0], own, 2);
  const MergedParts merged = merge({part(*scene, 1, 2), part(*scene, 2, 2)});
  EXPECT_EQ(merged.image.data, whole.data);
  EXPECT_NEAR(merged.image.data[0], 3.1416, 0.001);
}

}  // namespace
}  // namespace kinome::test::parts_test
