#include "clustered/product/trial_paths.h"

#include <algorithm>
#include <memory>

#include "clustered/product/shared_knowledge.h"
#include "clustered/product/spread.h"
#include "transport/camera_block.h"
#include "transport/paths.h"

namespace kinome {
namespace {

constexpr size_t kPixelsAtOnce = transport::kBlockSamples / TrialPaths::kPaths;

}  // namespace

struct TrialPaths::Worker {
  transport::CameraBlock camera;
  transport::Paths paths;
  std::vector<uint32_t> x, y;
};

void TrialPaths::trace_block(int block, const MethodTrial& trial, uint64_t seed, Worker& worker,
                             std::vector<Rgb>& picture, RenderCounters& counters) const {
  worker.x.clear();
  worker.y.clear();
  grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
    if (!trial.is_wanted(tile)) return;
    tile.for_each_pixel([&](int x, int y) {
      worker.x.push_back(static_cast<uint32_t>(x));
      worker.y.push_back(static_cast<uint32_t>(y));
    });
  });
  for (size_t first = 0; first < worker.x.size(); first += kPixelsAtOnce) {
    const size_t pixels = std::min(kPixelsAtOnce, worker.x.size() - first);
    const PixelSamples samples{&worker.x[first], &worker.y[first], pixels, 0, kPaths, seed};
    worker.camera.begin(samples, counters);
    const Columns3 radiance = worker.camera.radiance();
    worker.paths.add(samples, worker.camera.seen(), {radiance, radiance}, counters);
    for (size_t p = 0; p < pixels; ++p) {
      Rgb sum(0.f);
      for (uint32_t k = 0; k < kPaths; ++k) sum += radiance.at(p * kPaths + k);
      const auto x = static_cast<int32_t>(worker.x[first + p]);
      const auto y = static_cast<int32_t>(worker.y[first + p]);
      picture[grid_.pixel(x, y)] = sum / static_cast<float>(kPaths);
    }
  }
}

void TrialPaths::trace(const MethodTrial& trial, uint64_t seed, std::vector<Rgb>& picture) const {
  SharedItems shared([&](size_t block, SharedBytes& bytes) {
    const auto is_wanted = [&](const TileGrid::Tile& tile) { return trial.is_wanted(tile); };
    transfer_tiles(picture, grid_, static_cast<int>(block), is_wanted, bytes);
  });
  grid_.for_each_block<Worker>(
      context_, grid_.all_rows(), "trial",
      [&] {
        return std::unique_ptr<Worker>(
            new Worker{{scene_, sensor_, settings_},
                       {scene_, sensor_.sampler(), settings_, transport::kBlockSamples},
                       {},
                       {}});
      },
      [&](int block, Worker& worker, RenderCounters& counters) {
        trace_block(block, trial, seed, worker, picture, counters);
      },
      &shared);
}

}  // namespace kinome
