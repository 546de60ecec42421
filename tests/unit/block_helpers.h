#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "kinome/columns.h"
#include "kinome/plugin_registry.h"
#include "kinome/scene_loader.h"
#include "support/render.h"

/// What tests of functions over blocks need: columns whose padding is poisoned, and plugins of each
/// instruction set.
namespace kinome::test {

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// What lies behind a column's padding, and must stay there.
inline constexpr float kGuard = 12345.678f;

/// Numbers of values that end in, before and behind the end of vectors.
inline constexpr size_t kRanges[] = {1, 15, 16, 17, 33};

/// Columns of `count` values: all NaN, their padding included.
class BlockMemory {
 public:
  explicit BlockMemory(size_t count) : length_(padded(count)) {}
  BlockMemory(const BlockMemory&) = delete;
  BlockMemory& operator=(const BlockMemory&) = delete;
  ~BlockMemory() {
    for (const auto& column : columns_) {
      for (size_t i = length_; i < length_ + kBlockLanes; ++i) {
        EXPECT_EQ(column[i / kBlockLanes].values[i % kBlockLanes], kGuard)
            << "written behind a column's padding";
      }
    }
  }

  float* one() {
    columns_.push_back(std::make_unique<Lanes[]>(length_ / kBlockLanes + 1));
    float* const values = columns_.back()[0].values;
    std::fill(values, values + length_, kNan);
    std::fill(values + length_, values + length_ + kBlockLanes, kGuard);
    return values;
  }
  Columns2 two() { return {one(), one()}; }
  Columns3 three() { return {one(), one(), one()}; }
  /// Zeros.
  uint32_t* indices() {
    auto* const values = reinterpret_cast<uint32_t*>(one());
    std::memset(values, 0, length_ * sizeof(uint32_t));
    return values;
  }

 private:
  struct alignas(kColumnAlignment) Lanes {
    float values[kBlockLanes];
  };
  size_t length_;
  std::vector<std::unique_ptr<Lanes[]>> columns_;
};

/// Those that this processor has and plugins are built for.
inline std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets = {InstructionSet::kBaseline};
  for (const auto set : {InstructionSet::kX86V3, InstructionSet::kX86V4}) {
    if (set <= processor_instruction_set()) sets.push_back(set);
  }
  return sets;
}

/// For tests' names.
inline std::string name_of(InstructionSet set) {
  std::string name(to_string(set));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// An object whose plugins, nested ones included, are the ones for an instruction set.
template <class T>
std::shared_ptr<T> make_for(InstructionSet set, const std::string& xml) {
  auto folders = PluginRegistry::default_folders();  // KINOME_PLUGIN_PATH first
  folders.push_back(KINOME_TEST_PLUGINS);
  // Objects outlive the call, and libraries their registry.
  PluginRegistry registry(folders, set);
  return std::dynamic_pointer_cast<T>(load_object_from_string(xml, "test.xml", {}, registry));
}

inline float largest_difference(const Vec3& a, const Vec3& b) {
  return max_component(glm::abs(a - b));
}
inline float largest_coordinate(const Vec3& v) {
  return max_component(glm::abs(v));
}

}  // namespace kinome::test
