// Time of samplers per number or pair: as blocks, for each instruction set of the processor, and
// sample by sample. Rates are in samples per second.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "kinome/plugin_registry.h"
#include "kinome/sampler.h"
#include "kinome/scene_loader.h"

namespace kinome {
namespace {

constexpr size_t kSamples = 2048;

/// Pixels whose samples form a block of about kSamples, as integrators request them.
class Pixels {
 public:
  explicit Pixels(uint32_t samples) {
    const size_t count = std::max<size_t>(1, kSamples / samples);
    for (uint32_t i = 0; i < count; ++i) x_.push_back(40 + i % 8), y_.push_back(90 + i / 8);
    block_ = {x_.data(), y_.data(), count, 0, std::min<uint32_t>(samples, kSamples), 1};
  }
  const PixelSamples& block() const { return block_; }

 private:
  std::vector<uint32_t> x_, y_;
  PixelSamples block_;
};

enum class Mode { kLine, kSquare, kSquareBySamples };

void run(benchmark::State& state, const std::string& type, uint32_t samples, InstructionSet set,
         Mode mode) {
  PluginRegistry registry(PluginRegistry::default_folders(), set);
  const auto object = load_object_from_string("<sampler type=\"" + type +
                                                  "\"><integer name=\"sample_count\" value=\"" +
                                                  std::to_string(samples) + "\"/></sampler>",
                                              "benchmark", {}, registry);
  const auto& sampler = dynamic_cast<const Sampler&>(*object);
  const Pixels pixels(sampler.sample_count());
  const PixelSamples& block = pixels.block();
  std::array<std::vector<float>, 2> columns;
  for (std::vector<float>& column : columns) column.resize(padded(block.count()));
  const Columns2 out{columns[0].data(), columns[1].data()};
  uint32_t dimension = 0;
  for (auto _ : state) {
    if (mode == Mode::kLine) {
      sampler.fill_1d_block(block, dimension, out.x);
    } else if (mode == Mode::kSquare) {
      sampler.fill_2d_block(block, dimension, out);
    } else {
      for (size_t p = 0, i = 0; p < block.pixels; ++p) {
        for (uint32_t s = 0; s < block.samples; ++s, ++i) {
          out.set(i, sampler.value_2d({block.x[p], block.y[p], s, block.seed}, dimension));
        }
      }
    }
    benchmark::ClobberMemory();
    dimension = (dimension + 2) % 10;  // a path with two bounces has 10 dimensions
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(block.count()));
}

/// Returns the instruction sets that both the plugins and the processor support.
std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets{min_instruction_set()};
  for (const InstructionSet set : PluginRegistry(PluginRegistry::default_folders())
                                      .instruction_sets(Category::kSampler, "ldsampler")) {
    if (set > sets.back() && set <= processor_instruction_set()) sets.push_back(set);
  }
  return sets;
}

bool add_benchmarks() {
  const auto sets = instruction_sets();
  for (const char* const type :
       {"independent", "ldsampler", "stratified", "multijitter", "halton", "orthogonal"}) {
    const auto add = [type](uint32_t samples, const std::string& how, InstructionSet set,
                            Mode mode) {
      const std::string name =
          "sampler/" + std::string(type) + "/" + std::to_string(samples) + "/" + how;
      benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
        run(state, type, samples, set, mode);
      })->MinTime(0.05);
    };
    for (const uint32_t samples : {4u, 64u, 256u}) {
      for (const InstructionSet set : sets) {
        add(samples, std::string("line/") + to_string(set), set, Mode::kLine);
        add(samples, std::string("square/") + to_string(set), set, Mode::kSquare);
      }
      add(samples, "square/samples", sets.back(), Mode::kSquareBySamples);
    }
  }
  return true;
}
const bool kAdded = add_benchmarks();

}  // namespace
}  // namespace kinome
