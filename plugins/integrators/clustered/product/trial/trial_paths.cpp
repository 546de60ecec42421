#include "clustered/product/trial/trial_paths.h"

#include <memory>

#include "clustered/product/trial/path_tiles.h"
#include "clustered/product/pilot/shared_knowledge.h"

namespace kinome {

void TrialPaths::trace(const MethodTrial& trial, uint64_t seed, std::vector<Rgb>& image) const {
  const auto is_wanted = [&](const TileGrid::Tile& tile) { return trial.is_wanted(tile); };
  SharedItems shared([&](size_t block, SharedBytes& bytes) {
    transfer_tiles(image, grid_, static_cast<int>(block), is_wanted, bytes);
  });
  const auto set_means = [&](const PixelSamples& samples, const transport::CameraBlock& camera) {
    for (size_t p = 0; p < samples.pixels; ++p) {
      Rgb sum(0.f);
      for (uint32_t k = 0; k < kPaths; ++k) sum += camera.radiance().at(p * kPaths + k);
      const auto x = static_cast<int32_t>(samples.x[p]), y = static_cast<int32_t>(samples.y[p]);
      image[grid_.pixel(x, y)] = sum / static_cast<float>(kPaths);
    }
  };
  grid_.for_each_block<PathTiles>(
      context_, grid_.all_rows(), "trial",
      [&] { return std::make_unique<PathTiles>(scene_, sensor_, settings_); },
      [&](int block, PathTiles& paths, RenderCounters& counters) {
        paths.trace(grid_, block, kPaths, seed, counters, is_wanted, set_means);
      },
      &shared);
}

}  // namespace kinome
