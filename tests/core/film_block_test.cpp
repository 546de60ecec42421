// Tests that films add blocks of samples with the same weights as single samples, with the filters
// of each instruction set.

#include <gtest/gtest.h>

#include <cmath>

#include "support/film_xml.h"
#include "kinome/sampler.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

namespace kinome::test::film_block_test {
namespace {

/// Returns all sums of values and of weights of a film.
std::vector<double> sums_of(Film& film) {
  std::vector<double> sums;
  film.transfer([&](void* bytes, size_t count) {
    if (count <= sums.size() * sizeof(double) || count % sizeof(double) != 0) return;
    sums.resize(count / sizeof(double));
    std::memcpy(sums.data(), bytes, count);
  });
  return sums;
}

/// Samples in and around a tile. Some are far away, infinite or NaN.
struct Samples {
  Samples(size_t number, size_t values) : count(number), memory(count), position(memory.two()) {
    const auto random = [&](size_t i, size_t k) {
      return to_unit_float(static_cast<uint32_t>(hash_words(i, k)));
    };
    for (size_t k = 0; k < values; ++k) columns.push_back(memory.one());
    for (size_t i = 0; i < count; ++i) {
      position.set(i, {20 * random(i, 1) - 2, 16 * random(i, 2) - 2});
      for (size_t k = 0; k < values; ++k) columns[k][i] = random(i, 3 + k);
      if (i % 11 == 5) position.y[i] = i % 2 ? 1e30f : kNan;
      if (i % 13 == 7) columns[i % values][i] = i % 2 ? kInfinity : kNan;
    }
  }
  void add_one_by_one(FilmTile& tile) const {
    std::vector<float> values(columns.size());
    for (size_t i = 0; i < count; ++i) {
      for (size_t k = 0; k < values.size(); ++k) values[k] = columns[k][i];
      tile.add(position.at(i), values);
    }
  }

  size_t count;
  BlockMemory memory;
  Columns2 position;
  std::vector<float*> columns;
};

/// `rounding`: permitted error of a weight.
void expect_same(Film& film, float rounding) {
  for (const bool has_more : {false, true}) {
    for (const size_t count : {0, 1, 15, 16, 17, 33, 300}) {
      std::vector<std::vector<std::string>> layers(1);
      std::vector<FilmChannel> channels;
      if (has_more) {
        layers = {{"depth", "u", "v"}};
        channels = {{"u2", 0, 1, 2}, {"x2", 0, FilmChannel::kX, 2}};
      }
      const Samples samples(count, static_cast<size_t>(has_more ? 6 : 3));
      // The film has 16 x 12 pixels; the second tile is at its edge.
      for (const Rect& pixels : {Rect{3, 2, 11, 9}, Rect{0, 5, 16, 12}}) {
        film.prepare(layers, channels);
        FilmTile points = film.make_tile(pixels);
        samples.add_one_by_one(points);
        film.commit(points);
        const std::vector<double> expected = sums_of(film);
        film.prepare(layers, channels);
        FilmTile block = film.make_tile(pixels);
        block.add_block(samples.position, count, samples.columns);
        film.commit(block);
        const std::vector<double> sums = sums_of(film);
        EXPECT_EQ(block.non_finite(), points.non_finite());
        ASSERT_EQ(sums.size(), expected.size());
        ASSERT_GE(sums.size(), (has_more ? 9 : 4) * 16 * 12u);
        for (size_t i = 0; i < sums.size(); ++i) {
          ASSERT_NEAR(sums[i], expected[i], 2 * rounding * static_cast<double>(count))
              << count << ' ' << i;
        }
      }
    }
  }
}

std::string film_of(const std::string& filter) {
  return "<film type='hdrfilm'>" + film_size(16, 12) + filter + "</film>";
}

TEST(FilmBlocks, CountAsTheirSamplesDo) {
  for (const InstructionSet set : instruction_sets()) {
    for (const char* filter :
         {"<rfilter type='box'/>", "<rfilter type='tent'/>",
          "<rfilter type='tent'><float name='radius' value='2.3'/></rfilter>",
          "<rfilter type='tent'><float name='radius' value='0.51'/></rfilter>",
          "<rfilter type='mitchell'/>",
          "<rfilter type='catmullrom'/>",
          "<rfilter type='lanczos'/>",
          "<rfilter type='lanczos'><integer name='lobes' value='1'/></rfilter>",
          "<rfilter type='gaussian'/>",
          "<rfilter type='gaussian'><float name='stddev' value='0.2'/></rfilter>",
          "<rfilter type='gaussian'><float name='stddev' value='1.7'/></rfilter>"}) {
      SCOPED_TRACE(std::string(to_string(set)) + filter);
      // Tolerance: two ulps of the exponential or of sines. Other filters are exact.
      const std::string_view name = filter;
      const bool is_exact = name.find("gaussian") == name.npos && name.find("lanczos") == name.npos;
      expect_same(*make_for<Film>(set, film_of(filter)), is_exact ? 0.f : 2.5e-7f);
    }
  }
}

/// A filter without a block function. Its weights are asymmetric, so that all of them differ.
class PointFilter final : public ReconstructionFilter {
 public:
  explicit PointFilter(float radius) { radius_ = radius; }
  float eval(float x) const override { return std::abs(x) <= radius_ ? 1.3f + std::sin(x) : 0.f; }
};
class PlainFilm final : public Film {
 public:
  explicit PlainFilm(float radius) {
    width_ = 16, height_ = 12;
    crop_ = {0, 0, 16, 12};
    filter_ = std::make_shared<PointFilter>(radius);
  }
  void write(const std::string&, const Image&, const ImageMetadata&) const override {}
  std::string file_extension() const override { return ".none"; }
};

TEST(FilmBlocks, OfAFilterOfPointsAreTheSame) {
  for (const float radius : {0.5f, 0.7f, 1.f, 1.5f, 4.25f}) {
    PlainFilm film(radius);
    expect_same(film, 0);
  }
}

TEST(FilmBlocks, TakeAsManyValuesAsTheFilmHas) {
  PlainFilm film(0.5f);
  film.prepare({{}});
  FilmTile tile = film.make_tile({0, 0, 4, 4});
  const Samples samples(3, 4);
  EXPECT_THROW(tile.add_block(samples.position, 3, samples.columns), std::logic_error);
}

}  // namespace
}  // namespace kinome::test::film_block_test
