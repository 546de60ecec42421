#include "clustered/product/trial_paths.h"

#include <memory>

#include "clustered/product/eye_paths.h"
#include "clustered/product/shared_knowledge.h"
#include "clustered/product/spread.h"
#include "kinome/film.h"

namespace kinome {
namespace {

constexpr uint32_t kPaths = 16;  ///< of each pixel

}  // namespace

void TrialPaths::trace(const MethodTrial& trial, uint64_t seed, std::vector<Rgb>& picture) const {
  SharedItems shared([&](size_t block, SharedBytes& bytes) {
    const auto is_wanted = [&](const TileGrid::Tile& tile) { return trial.is_wanted(tile); };
    transfer_tiles(picture, grid_, static_cast<int>(block), is_wanted, bytes);
  });
  grid_.for_each_block<EyePaths>(
      context_, grid_.all_rows(), "trial",
      [&] { return std::make_unique<EyePaths>(scene_, PathSettings{length_, false}, 0, nullptr); },
      [&](int block, EyePaths& paths, RenderCounters& counters) {
        const auto for_each_pixel = [&](const auto& fn) {
          grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
            if (trial.is_wanted(tile)) tile.for_each_pixel(fn);
          });
        };
        for_each_pixel([&](int x, int y) {
          for (uint32_t k = 0; k < kPaths; ++k) {
            const uint64_t own = hash_words(seed, grid_.pixel(x, y), k);
            const Vec2 place = film_position(x, y, {random_float(own, 0), random_float(own, 1)});
            EyePaths::Begin path;
            path.ray = sensor_.sample_ray(place, {random_float(own, 2), random_float(own, 3)});
            path.throughput = Rgb(1.f);
            path.seed = hash_words(own, 4);
            path.sum = &picture[grid_.pixel(x, y)];
            paths.push(path);
          }
        });
        paths.trace(counters);
        for_each_pixel([&](int x, int y) { picture[grid_.pixel(x, y)] /= kPaths; });
      },
      &shared);
}

}  // namespace kinome
