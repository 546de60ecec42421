#include <array>

#include "fuzz.h"
#include "kinome/volume.h"

/// Reads the input as a grid of voxels, and evaluates the grid inside, outside and nowhere.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace kinome;
  static const fuzz::InputFile file(".vol");
  const auto volume = std::dynamic_pointer_cast<Volume>(
      fuzz::load_file(Category::kVolume, "gridvolume", file.write(data, size)));
  if (!volume) return 0;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr std::array kAxis{-1e30f, -0.1f, 0.f, 0.3f, 1.f, 7.f, kNan, kInfinity};
  float values[Volume::kMaxChannels];
  for (size_t i = 0; i < kAxis.size() * kAxis.size(); ++i) {
    volume->eval(Vec3(kAxis[i % 8], kAxis[i / 8], kAxis[(i * 3) % 8]), values);
  }
  float lo[8], hi[8];
  volume->extremes({volume->box(), {2, 2, 2}}, lo, hi);
  alignas(kColumnAlignment) float column[7][kBlockLanes] = {};
  column[0][0] = 0.1f, column[3][0] = 0.6f, column[4][0] = 0.8f;
  alignas(kColumnAlignment) float sums[Volume::kMaxChannels][kBlockLanes];
  float* out[Volume::kMaxChannels];
  for (size_t c = 0; c < Volume::kMaxChannels; ++c) out[c] = sums[c];
  const float length[kBlockLanes] = {0.9f};
  volume->integral_block({column[0], column[1], column[2]}, {column[3], column[4], column[5]},
                         length, 1, out);
  return 0;
}
