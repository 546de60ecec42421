// Time of BSDFs per point, for value and sample: as blocks, for each instruction set of the
// processor, and point by point. Rates are in points per second.
#include <benchmark/benchmark.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "kinome/bsdf.h"
#include "kinome/plugin_registry.h"
#include "kinome/scene_loader.h"
#include "kinome/warp.h"

namespace kinome {
namespace {

constexpr size_t kPoints = 2048;

/// Points seen from the front, and directions to the light. Half of the directions are near the
/// mirror direction.
struct Block {
  Block() : memory(kColumns * kPoints + kBlockLanes), indices(2 * kPoints), shapes(kPoints) {
    next = memory.data() + (-reinterpret_cast<uintptr_t>(memory.data()) % 64) / sizeof(float);
    points = {kPoints,
              three(),
              three(),
              three(),
              three(),
              three(),
              three(),
              three(),
              three(),
              {one(), one()},
              one(),
              indices.data(),
              indices.data() + kPoints,
              shapes.data()};
    query = {three(), one(), {one(), one()}};
    answer = {three(), one(), three(), three(), one(), one()};
    std::mt19937 rng(1);
    const auto unit = [&] { return static_cast<float>(rng() >> 8) * 0x1p-24f; };
    for (size_t i = 0; i < kPoints; ++i) {
      const Frame frame = Frame::from_normal(square_to_uniform_sphere({unit(), unit()}));
      for (const Columns3& n : {points.n, points.sn}) n.set(i, frame.n);
      for (const Columns3& s : {points.s, points.dp_du}) s.set(i, frame.s);
      for (const Columns3& t : {points.t, points.dp_dv}) t.set(i, frame.t);
      points.p.set(i, Vec3(0.f));
      points.uv.set(i, {unit(), unit()});
      const Vec3 wi = square_to_uniform_hemisphere({unit(), unit()});
      const Vec3 any = square_to_uniform_hemisphere({unit(), unit()});
      points.wi.set(i, wi);
      query.wo.set(i, i % 2 ? any : glm::normalize(Vec3(-wi.x, -wi.y, wi.z) + 0.2f * any));
      query.u1[i] = unit();
      query.u2.set(i, {unit(), unit()});
    }
  }
  float* one() { return std::exchange(next, next + kPoints); }
  Columns3 three() {
    float* const x = one();
    float* const y = one();
    return {x, y, one()};
  }

  static constexpr size_t kColumns = 48;
  std::vector<float> memory;
  std::vector<uint32_t> indices;
  std::vector<const Shape*> shapes;
  float* next;
  SurfaceBlock points;
  BsdfQuery query;
  BsdfAnswer answer;
};

void run(benchmark::State& state, const std::string& xml, InstructionSet set, bool by_points) {
  PluginRegistry registry(PluginRegistry::default_folders(), set);
  const auto object = load_object_from_string(xml, "benchmark", {}, registry);
  const auto& bsdf = dynamic_cast<const Bsdf&>(*object);
  Block block;
  for (auto _ : state) {
    if (by_points) {
      bsdf.Bsdf::shade_block(block.points, block.query, block.answer);
    } else {
      bsdf.shade_block(block.points, block.query, block.answer);
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * kPoints));
}

const bool kRegistered = [] {
  const std::pair<const char*, const char*> bsdfs[] = {
      {"diffuse", "<bsdf type='diffuse'/>"},
      {"plastic", "<bsdf type='plastic'/>"},
      {"phong", "<bsdf type='phong'/>"},
      {"ward", "<bsdf type='ward'/>"},
      {"roughplastic", "<bsdf type='roughplastic'/>"},
      {"roughplastic_ggx",
       "<bsdf type='roughplastic'><string name='distribution' value='ggx'/></bsdf>"},
      {"roughconductor", "<bsdf type='roughconductor'><string name='material' value='Cu'/></bsdf>"},
      {"roughconductor_ggx",
       "<bsdf type='roughconductor'><string name='material' value='Cu'/>"
       "<string name='distribution' value='ggx'/></bsdf>"},
      {"twosided", "<bsdf type='twosided'><bsdf type='roughplastic'/></bsdf>"},
      {"normalmap",
       "<bsdf type='normalmap'><texture type='checkerboard' name='normalmap'>"
       "<rgb name='color0' value='.5 .5 1'/><rgb name='color1' value='.6 .5 .9'/></texture>"
       "<bsdf type='diffuse'/></bsdf>"},
  };
  for (const auto& [name, xml] : bsdfs) {
    for (int i = static_cast<int>(min_instruction_set());
         i <= static_cast<int>(processor_instruction_set()); ++i) {
      const auto set = static_cast<InstructionSet>(i);
      for (const bool by_points : {false, true}) {
        benchmark::RegisterBenchmark((std::string("bsdf/") + name + "/" + to_string(set) +
                                      (by_points ? "/points" : "/block"))
                                         .c_str(),
                                     run, std::string(xml), set, by_points);
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace kinome
