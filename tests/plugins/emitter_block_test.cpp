#include <gtest/gtest.h>

#include <cmath>

#include "kinome/image_files.h"
#include "kinome/emitter.h"
#include "kinome/image.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "support/shape_helpers.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

/// Compares emitters over blocks with the same emitters at single points, for each instruction set.
/// Tolerances are multiples of kRounding, a few roundings of numbers of magnitude 1.
namespace kinome::test::emitter_block_test {
namespace {

constexpr float kRounding = 8 * 0x1p-24f;

struct Case {
  std::string name, xml;
  float largest = 1;  ///< largest radiance or intensity
  /// Change of the radiance if the direction is rounded, in kRounding of the largest radiance.
  float sharpness = 1;
};

Image black_image(int width, int height) {
  return {width, height, {"R", "G", "B"}, std::vector<float>(size_t{3} * width * height, 0.f)};
}

/// Returns noise over several magnitudes, with a black corner.
Image noise(int width, int height) {
  Image image = black_image(width, height);
  Random random(5);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float value = x + y < 4 ? 0 : std::exp(random.between(-6, 3));
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = value * random.between(.5f, 1);
    }
  }
  return image;
}
constexpr float kLargestNoise = 20.1f;

std::string file(const TemporaryFolder& folder, const std::string& name, const Image& image) {
  write_pfm(folder.path(name), image);
  return "<string name='filename' value='" + folder.path(name) + "'/>";
}

const std::vector<Case>& lights() {
  static const TemporaryFolder folder;
  static const std::vector<Case> all = [] {
    const std::string map = file(folder, "map.pfm", noise(64, 40));
    const std::string tiny = file(folder, "tiny.pfm", noise(5, 3));
    const std::string black = file(folder, "black.pfm", black_image(8, 4));
    const std::string slide = file(folder, "slide.pfm", noise(7, 5));
    const std::string look =
        "<transform name='to_world'><lookat origin='.3, .2, -1' target='0, 0, 1' up='0, 1, 0'/>"
        "</transform>";
    const std::string turn =
        "<transform name='to_world'><rotate x='.36' y='.48' z='.8' angle='50'/></transform>";
    const auto emitter = [](const std::string& type, const std::string& inside) {
      return "<emitter type='" + type + "'>" + inside + "</emitter>";
    };
    const std::string texture = "<texture name='texture' type='bitmap'>" + slide + "</texture>";
    const std::string irradiance =
        "<texture name='irradiance' type='bitmap'>" + slide + "</texture>";
    return std::vector<Case>{
        {"constant", emitter("constant", "<rgb name='radiance' value='1 .5 .25'/>")},
        {"constant black", emitter("constant", "<rgb name='radiance' value='0 0 0'/>")},
        {"directional", emitter("directional", "<vector name='direction' value='1, -2, .5'/>")},
        {"directional black", emitter("directional", "<rgb name='irradiance' value='0 0 0'/>")},
        {"point", emitter("point", "<point name='position' value='.3, .2, -1'/>")},
        {"point black", emitter("point", "<rgb name='intensity' value='0 0 0'/>")},
        {"spot", emitter("spot", look), 1, 12},
        {"spot wide", emitter("spot", look + "<float name='cutoff_angle' value='150'/>"), 1, 2},
        {"spot of texture", emitter("spot", look + texture), kLargestNoise, 100},
        {"projector", emitter("projector", look), 8},
        {"projector of texture", emitter("projector", look + irradiance), 8 * kLargestNoise, 100},
        // The sharpness is the number of the map's columns, which span a full turn.
        {"envmap", emitter("envmap", map), kLargestNoise, 64},
        {"envmap turned", emitter("envmap", map + turn), kLargestNoise, 64},
        {"envmap compensated",
         emitter("envmap", map + "<boolean name='mis_compensation' value='true'/>"), kLargestNoise,
         64},
        {"envmap tiny", emitter("envmap", tiny), kLargestNoise, 64},
        {"envmap black", emitter("envmap", black)},
    };
  }();
  return all;
}

const std::vector<Case>& surfaces() {
  static const TemporaryFolder folder;
  static const std::vector<Case> all = [] {
    const std::string area = "<emitter type='area'><rgb name='radiance' value='3 2 1'/></emitter>";
    const std::string slide = file(folder, "slide.pfm", noise(7, 5));
    const std::string textured = "<emitter type='area'><texture name='radiance' type='bitmap'>" +
                                 slide + "</texture></emitter>";
    const std::string black =
        "<emitter type='area'><rgb name='radiance' value='0 0 0'/></emitter>";
    std::vector<Case> cases;
    for (const std::string type : {"rectangle", "cube", "sphere", "cylinder", "disk"}) {
      const std::string start = "<shape type='" + type + "'>";
      cases.push_back({type, start + area + "</shape>", 3});
      cases.push_back({type + " of texture", start + textured + "</shape>", kLargestNoise, 100});
      cases.push_back({type + " black", start + black + "</shape>", 0});
    }
    return cases;
  }();
  return all;
}

class EmitterBlocks : public testing::TestWithParam<InstructionSet> {
 protected:
  template <class Action>
  void for_lights(const Action& action) const {
    for (const Case& c : lights()) {
      SCOPED_TRACE(c.name);
      const auto emitter = make_for<Emitter>(GetParam(), c.xml);
      ASSERT_TRUE(emitter);
      action(c, *emitter);
    }
  }
  template <class Action>
  void for_surfaces(const Action& action) const {
    for (const Case& c : surfaces()) {
      SCOPED_TRACE(c.name);
      const auto shape = make_for<Shape>(GetParam(), c.xml);
      ASSERT_TRUE(shape && shape->emitter());
      action(c, *shape, *shape->emitter());
    }
  }
};

struct DirectMemory {
  explicit DirectMemory(size_t count)
      : memory(count),
        p(memory.three()),
        u(memory.two()),
        out{memory.three(), memory.one(), memory.one(), memory.three(), memory.one()} {}
  BlockMemory memory;
  Columns3 p;
  Columns2 u;
  DirectBlock out;
};

/// `share`: permitted relative rounding error of the pdf and the radiance.
void expect_same(const Case& c, const std::optional<DirectSample>& expected, const DirectBlock& out,
                 size_t i, float share) {
  const DirectSample light = expected.value_or(DirectSample{});
  // Near the edge of the light, rounding may decide whether it is visible.
  const float scale = light.is_delta && light.distance < kInfinity ? sqr(light.distance) : 1;
  const float slack = kRounding * c.sharpness * c.largest / scale;
  const bool is_seen = out.pdf[i] > 0;
  const Rgb radiance = is_seen ? out.radiance.at(i) : Rgb(0.f);
  EXPECT_LE(largest_difference(radiance, light.radiance),
            slack + share * largest_coordinate(light.radiance));
  if (is_seen != expected.has_value()) {
    EXPECT_LE(largest_coordinate(radiance + light.radiance), 4 * slack);
    return;
  }
  if (!is_seen) return;
  EXPECT_NEAR(out.pdf[i], light.pdf, light.pdf * share);
  EXPECT_LE(largest_difference(out.d.at(i), light.d), share);
  EXPECT_EQ(out.is_delta[i], light.is_delta ? 1 : 0);
  if (light.distance < kInfinity) {
    EXPECT_NEAR(out.distance[i], light.distance, light.distance * share);
  } else {
    EXPECT_EQ(out.distance[i], kInfinity);
  }
}

TEST_P(EmitterBlocks, AreSampledAsFromPoints) {
  for_lights([](const Case& c, const Emitter& emitter) {
    Random random(1);
    for (const size_t count : {size_t{1}, size_t{15}, size_t{16}, size_t{17}, size_t{33},
                               size_t{700}}) {
      for (int repeat = 0; repeat < 5; ++repeat) {
        DirectMemory block(count);
        for (size_t i = 0; i < count; ++i) {
          const float far = random.unit() < .1f ? 1e10f : 1.f;
          block.p.set(i, Vec3(.3f, .2f, -1) +
                             random.direction() * (far * std::exp(random.between(-5, 5))));
          if (i % 16 == 3) block.p.set(i, {.3f, .2f, -1});  // at the emitter itself
          if (emitter.is_delta()) continue;  // lamps ignore their random numbers, which stay NaN
          block.u.set(i, {random.unit(), random.unit()});
          if (i % 16 == 5) block.u.set(i, {0, 0});
          if (i % 16 == 7) block.u.set(i, {kOneMinusEpsilon, kOneMinusEpsilon});
        }
        emitter.sample_direct_block(block.p, block.u, count, block.out);
        for (size_t i = 0; i < count; ++i) {
          const Vec3 p = block.p.at(i);
          expect_same(c, emitter.sample_direct(p, block.u.at(i)), block.out, i, 2 * kRounding);
          if (testing::Test::HasFailure()) {
            FAIL() << "at " << i << " of " << count << ", u " << block.u.x[i] << ' ' << block.u.y[i]
                   << ", p " << p.x << ' ' << p.y << ' ' << p.z;
          }
        }
      }
    }
  });
}

TEST_P(EmitterBlocks, DeltasSaySo) {
  for_lights([](const Case& c, const Emitter& emitter) {
    const bool is_map_or_sky = c.name.starts_with("constant") || c.name.starts_with("envmap");
    EXPECT_EQ(emitter.is_delta(), !is_map_or_sky);
  });
  for_surfaces([](const Case&, const Shape&, const Emitter& emitter) {
    EXPECT_FALSE(emitter.is_delta());
  });
}

TEST_P(EmitterBlocks, EnvironmentsAreThoseOfDirections) {
  for_lights([](const Case& c, const Emitter& emitter) {
    if (!emitter.is_environment()) return;
    Random random(2);
    for (const size_t count : {size_t{1}, size_t{15}, size_t{16}, size_t{17}, size_t{33},
                               size_t{700}}) {
      for (const bool with_pdf : {true, false}) {
        BlockMemory memory(count);
        const Columns3 d = memory.three(), radiance = memory.three();
        float* const pdf = memory.one();
        for (size_t i = 0; i < count; ++i) {
          d.set(i, random.direction());
          // The poles, directions near them, and the seam of the columns.
          if (i % 16 == 1) d.set(i, {0, i % 32 < 16 ? 1 : -1, 0});
          if (i % 16 == 3) d.set(i, glm::normalize(Vec3(1e-4f * random.unit(), -1, 1e-5f)));
          if (i % 16 == 5) d.set(i, {0, 0, i % 32 < 16 ? 1 : -1});
          if (i % 16 == 7) d.set(i, {-0.f, 0, -1});
        }
        emitter.eval_environment_block(d, count, radiance, with_pdf ? pdf : nullptr);
        for (size_t i = 0; i < count; ++i) {
          const float slack = 4 * kRounding * c.sharpness;
          ASSERT_LE(largest_difference(radiance.at(i), emitter.eval_environment(d.at(i))),
                    slack * c.largest)
              << "at " << i << " of " << count;
          if (!with_pdf) continue;
          const float expected = emitter.pdf_environment(d.at(i));
          // The map's largest density is at most some ten times that of a uniform distribution.
          ASSERT_NEAR(pdf[i], expected, slack * 20 * kUniformSpherePdf + 4 * kRounding * expected)
              << "at " << i << " of " << count;
        }
      }
    }
  });
}

TEST_P(EmitterBlocks, EnvironmentsKeepNaNToItself) {
  for_lights([](const Case&, const Emitter& emitter) {
    if (!emitter.is_environment()) return;
    BlockMemory memory(16);
    const Columns3 d = memory.three(), radiance = memory.three();
    for (size_t i = 0; i < 16; ++i) {
      if (i % 2 == 0) d.set(i, {0, 0, 1});
    }
    emitter.eval_environment_block(d, 16, radiance, nullptr);
    for (size_t i = 0; i < 16; i += 2) {
      EXPECT_LE(largest_difference(radiance.at(i), emitter.eval_environment({0, 0, 1})), 1e-3f);
    }
  });
}

TEST_P(EmitterBlocks, SurfacesAreSampledAsFromPoints) {
  for_surfaces([](const Case& c, const Shape& shape, const Emitter& emitter) {
    Random random(3);
    for (const size_t count : kRanges) {
      for (int repeat = 0; repeat < 20; ++repeat) {
        DirectMemory block(count);
        for (size_t i = 0; i < count; ++i) {
          block.p.set(i, random.direction() * std::exp(random.between(-2, 5)));
          block.u.set(i, {random.unit(), random.unit()});
        }
        emitter.sample_direct_block(block.p, block.u, count, block.out);
        for (size_t i = 0; i < count; ++i) {
          const Vec3 p = block.p.at(i);
          const auto expected = emitter.sample_direct(p, block.u.at(i));
          const auto sample = shape.sample_solid_angle(p, block.u.at(i));
          if (!sample) continue;
          // Positions have the error p_error, which matters at small distances and grazing angles.
          const Vec3 to = sample->si.p - p;
          const float height = std::abs(glm::dot(sample->si.n, to));
          const float share =
              kRounding * (4 + 2 * glm::length(to) / height) + 8 * sample->si.p_error / height;
          if (!(share < 1e-3f)) continue;
          expect_same(c, expected, block.out, i, share);
          if (testing::Test::HasFailure()) FAIL() << "at " << i << " of " << count;
        }
      }
    }
  });
}

TEST_P(EmitterBlocks, SurfacesShineAsAtPoints) {
  for_surfaces([](const Case& c, const Shape& shape, const Emitter& emitter) {
    Random random(4);
    for (const size_t count : kRanges) {
      for (const bool with_pdf : {true, false}) {
        BlockMemory memory(count);
        SurfaceBlock points;
        points.count = count;
        for (Columns3* column :
             {&points.p, &points.n, &points.s, &points.t, &points.sn, &points.wi}) {
          *column = memory.three();
        }
        points.uv = memory.two();
        points.p_error = memory.one();
        points.primitive = memory.indices();
        points.ray = memory.indices();
        std::vector<const Shape*> shapes(padded(count), &shape);
        points.shape = shapes.data();
        const Columns3 from = memory.three(), radiance = memory.three();
        float* const pdf = memory.one();
        std::vector<SurfaceInteraction> single(count);
        for (size_t i = 0; i < count; ++i) {
          SurfaceInteraction& si = single[i];
          si = shape.sample_surface({random.unit(), random.unit()});
          si.wi = random.direction();
          points.p.set(i, si.p), points.n.set(i, si.n), points.wi.set(i, si.wi);
          points.s.set(i, si.frame.s), points.t.set(i, si.frame.t);
          points.sn.set(i, si.frame.n), points.uv.set(i, si.uv);
          points.p_error[i] = si.p_error;
          from.set(i, random.direction() * std::exp(random.between(0, 5)));
        }
        emitter.eval_surface_block(points, from, radiance, with_pdf ? pdf : nullptr);
        for (size_t i = 0; i < count; ++i) {
          ASSERT_LE(largest_difference(radiance.at(i), emitter.eval_surface(single[i])),
                    kRounding * c.largest * c.sharpness);
          if (!with_pdf) continue;
          const float expected = emitter.pdf_surface(from.at(i), single[i]);
          const Vec3 to = single[i].p - from.at(i);
          const float cosine = std::abs(glm::dot(single[i].n, to)) / glm::length(to);
          ASSERT_NEAR(pdf[i], expected, expected * kRounding * (1 + 1 / cosine));
        }
      }
    }
  });
}

struct EmissionMemory {
  explicit EmissionMemory(size_t count)
      : memory(count),
        position(memory.two()),
        direction(memory.two()),
        out{memory.three(), memory.three(), memory.three()} {}
  BlockMemory memory;
  Columns2 position, direction;
  EmissionBlock out;
};

/// `size`: magnitude of the coordinates of ray origins.
void expect_same_rays(const Case& c, const Emitter& emitter, const EmissionMemory& block, size_t i,
                      float size) {
  const Vec2 position = block.position.at(i), direction = block.direction.at(i);
  const EmissionSample expected =
      emitter.sample_emission(position, direction).value_or(EmissionSample{});
  const Rgb power = block.out.power.at(i);
  if (is_black(expected.power)) {
    // Near the edge of the light, rounding may decide whether power is emitted.
    ASSERT_LE(largest_coordinate(power), 1e-4f * c.largest);
    return;
  }
  const auto share = [](float pdf) { return pdf > 0 ? 1 / pdf : 1; };
  const float shown = c.largest * share(expected.pdf_direction) * share(expected.pdf_position);
  ASSERT_LE(largest_difference(power, expected.power),
            2 * kRounding * c.sharpness * std::max(largest_coordinate(expected.power), shown));
  const Ray ray = expected.ray();
  EXPECT_LE(largest_difference(block.out.o.at(i), ray.o), 2 * kRounding * size);
  // The height over a surface is the square root of a difference from 1.
  const float height = is_black(expected.n) ? 1 : std::abs(glm::dot(expected.n, expected.d));
  EXPECT_LE(largest_difference(block.out.d.at(i), ray.d), kRounding * (2 + 1 / height));
}

void fill_numbers(Random& random, size_t count, const EmissionMemory& block) {
  for (size_t i = 0; i < count; ++i) {
    block.position.set(i, {random.unit(), random.unit()});
    block.direction.set(i, {random.unit(), random.unit()});
    if (i % 16 == 5) block.position.set(i, {0, 0});
    if (i % 16 == 7) block.position.set(i, {kOneMinusEpsilon, kOneMinusEpsilon});
  }
}

TEST_P(EmitterBlocks, SendRaysAsOneByOne) {
  for_lights([&](const Case& c, const Emitter&) {
    const auto emitter = make_for<Emitter>(GetParam(), c.xml);
    emitter->prepare({Vec3(-2, -1, -3), Vec3(2, 4, 1)});
    Random random(5);
    for (const size_t count : {size_t{1}, size_t{15}, size_t{16}, size_t{17}, size_t{33},
                               size_t{700}}) {
      EmissionMemory block(count);
      fill_numbers(random, count, block);
      emitter->sample_emission_block(block.position, block.direction, count, block.out);
      for (size_t i = 0; i < count; ++i) {
        expect_same_rays(c, *emitter, block, i, 16);
        if (testing::Test::HasFailure()) FAIL() << "at " << i << " of " << count;
      }
    }
  });
}

TEST_P(EmitterBlocks, SurfacesSendRaysAsOneByOne) {
  for_surfaces([](const Case& c, const Shape&, const Emitter& emitter) {
    Random random(6);
    for (const size_t count : kRanges) {
      for (int repeat = 0; repeat < 10; ++repeat) {
        EmissionMemory block(count);
        fill_numbers(random, count, block);
        emitter.sample_emission_block(block.position, block.direction, count, block.out);
        for (size_t i = 0; i < count; ++i) {
          expect_same_rays(c, emitter, block, i, 2);
          if (testing::Test::HasFailure()) FAIL() << "at " << i << " of " << count;
        }
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Sets, EmitterBlocks, testing::ValuesIn(instruction_sets()),
                         [](const auto& set) { return name_of(set.param); });

}  // namespace
}  // namespace kinome::test::emitter_block_test
