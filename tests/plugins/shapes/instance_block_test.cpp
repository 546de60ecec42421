#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>

#include "kinome/block_points.h"
#include "kinome/texture.h"
#include "plugins/shapes/instances.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"
#include "support/shape_helpers.h"

/// Tests blocks, memory, attributes and errors of instances.
namespace kinome::test::instance_block_test {
namespace {

using namespace instances;

TEST_F(Instances, ReadTheirGroupsAttributes) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.ply", R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
property float q_x
element face 1
property list uchar int vertex_indices
end_header
0 0 0 1
1 0 0 2
0 1 0 4
3 0 1 2
)");
  const std::string texture =
      "<texture type='mesh_attribute' name='reflectance'><string name='name' value='vertex_q'/>"
      "</texture>";
  const auto scene =
      scene_from(group_of("<shape type='ply'><string name='filename' value='" + file +
                          "'/><bsdf type='diffuse'>" + texture + "</bsdf></shape>") +
                 instance("<scale x='10' y='-3' z='2'/><translate x='100'/>"));
  const RayHit hit = trace(*scene, {102, -.9f, 5}, {0, 0, -1});
  ASSERT_TRUE(hit.hit.valid());
  EXPECT_NEAR(make<Texture>(texture)->eval_at(scene->interaction(hit)).x, .5f + .2f * 2 + .3f * 4,
              1e-4f);
}

TEST_F(Instances, ReportErrors) {
  const auto fault = [](const std::string& xml) {
    const std::string message = error_of([&] { scene_from(xml); });
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(message.find("test.xml:"), 0u) << message;
    return message;
  };
  const auto says = [](const std::string& message, const std::string& what) {
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  const std::string ball = "<shape type='sphere'/>";
  says(fault("<shape type='instance'/>"), "shape");
  says(fault("<shape type='instance'>" + ball + "</shape>"), "requires a nested 'shapegroup'");
  says(fault(group_of("<shape type='sphere'><emitter type='area'/></shape>")), "can't emit");
  says(fault(group_of("<shape type='merge'>" + ball +
                      "<shape type='sphere'><emitter type='area'/></shape></shape>")),
       "can't emit");
  says(fault(group_of(group_of(ball))), "can't be part of another");
  says(fault(group_of(ball) + "<shape type='shapegroup'>" + instance("") + "</shape>"),
       "can't contain instances");
  says(fault(group_of(ball) + "<shape type='shapegroup'><shape type='merge'>" + instance("") +
             "</shape></shape>"),
       "can't contain instances");
  says(
      fault("<shape type='shapegroup' id='a'><shape type='instance'><ref id='a'/></shape></shape>"),
      "part of");
  says(fault(group_of(ball) + instance("<scale x='0'/>")), "singular");
  says(fault(group_of(ball) + instance("<matrix value='1 0 0 0  0 1 0 0  0 0 1 0  0 0 1 1'/>")),
       "must be an affine transform");
  says(fault(group_of(ball) +
             "<shape type='instance'><ref id='group'/><bsdf type='diffuse'/></shape>"),
       "bsdf");
}

size_t resident_bytes() {
  std::ifstream in("/proc/self/statm");
  size_t all = 0, resident = 0;
  in >> all >> resident;
  return resident * 4096;
}

/// A mesh of 10^5 triangles takes some 10 MB with its BVH; 10,000 copies would take 100 GB.
TEST_F(Instances, TakeNoMemoryForTheirShapes) {
  const TemporaryFolder folder;
  std::ostringstream mesh;
  constexpr int kSide = 224;
  mesh << "ply\nformat ascii 1.0\nelement vertex " << kSide * kSide
       << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
       << 2 * (kSide - 1) * (kSide - 1) << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < kSide * kSide; ++i) {
    mesh << i % kSide << ' ' << i / kSide << ' ' << (i * 7919) % 13 * .1 << '\n';
  }
  for (int i = 0; i < kSide * (kSide - 1); ++i) {
    if (i % kSide == kSide - 1) continue;
    mesh << "3 " << i << ' ' << i + 1 << ' ' << i + kSide << "\n3 " << i + 1 << ' ' << i + kSide + 1
         << ' ' << i + kSide << '\n';
  }
  const std::string group = group_of("<shape type='ply'><string name='filename' value='" +
                                     folder.write("field.ply", mesh.str()) + "'/></shape>");
  const size_t before = resident_bytes();
  const auto one = scene_from(group + instance(""));
  const size_t with_one = resident_bytes();
  std::string many;
  constexpr int kCopies = 10000;
  for (int i = 0; i < kCopies; ++i) {
    many += instance("<translate x='" + std::to_string(i % 100 * 300) + "' y='" +
                     std::to_string(i / 100 * 300) + "'/>");
  }
  const auto scene = scene_from(group + many);
  const size_t with_many = resident_bytes();
  EXPECT_EQ(scene->shapes().size(), size_t{kCopies});
  EXPECT_LT(with_many - with_one, (with_one - before) + (size_t{500} << 20));
  const RayHit hit = trace(*scene, {99 * 300 + 50.3f, 98 * 300 + 50.3f, 100}, {0, 0, -1});
  EXPECT_EQ(hit.hit.shape, 9899u);
}

class InstanceBlocks : public testing::TestWithParam<InstructionSet> {};

TEST_P(InstanceBlocks, MatchSinglePoints) {
  for (const char* inner : {"cube", "sphere"}) {
    for (const char* operations : {kAffine, kMirrored}) {
      SCOPED_TRACE(std::string(inner) + operations);
      const auto placed = make_for<Shape>(
          GetParam(), "<shape type='instance'><shape type='shapegroup'><shape type='" +
                          std::string(inner) + "'/></shape>" + moved(operations) + "</shape>");
      const Shape& part = *placed->parts().at(0);
      const auto scene = scene_from(group_of("<shape type='" + std::string(inner) + "'/>") +
                                    instance(operations));
      Random random(5);
      for (const size_t count : kRanges) {
        for (const bool wants_derivatives : {false, true}) {
          BlockMemory memory(count);
          std::vector<RayHit16> rays(padded(count) / 16 + 1);
          SurfaceBlock points;
          points.count = count;
          for (Columns3* c : {&points.p, &points.n, &points.s, &points.t, &points.sn, &points.wi}) {
            *c = memory.three();
          }
          if (wants_derivatives) points.dp_du = memory.three(), points.dp_dv = memory.three();
          points.uv = memory.two();
          points.p_error = memory.one();
          points.primitive = memory.indices(), points.ray = memory.indices();
          std::vector<RayHit> hits;
          while (hits.size() < count) {
            const Vec3 o = Vec3(3, -2, .5f) + 9.f * random.direction();
            const RayHit hit = trace(*scene, o, Vec3(3, -2, .5f) + 0.5f * random.direction() - o);
            if (!hit.hit.valid()) continue;
            const size_t i = hits.size(), k = count - 1 - i;
            RayHit16& to = rays[k / 16];
            Columns3{to.ray.ox, to.ray.oy, to.ray.oz}.set(k % 16, hit.ray.o);
            Columns3{to.ray.dx, to.ray.dy, to.ray.dz}.set(k % 16, hit.ray.d);
            to.ray.tmax[k % 16] = hit.ray.tmax;
            to.u[k % 16] = hit.hit.u, to.v[k % 16] = hit.hit.v;
            to.primitive[k % 16] = hit.hit.primitive;
            points.ray[i] = static_cast<uint32_t>(k);
            hits.push_back(hit);
          }
          part.interaction_block(rays.data(), points);
          for (size_t i = 0; i < count; ++i) {
            const SurfaceInteraction si = part.interaction(hits[i].ray, hits[i].hit);
            constexpr float kNear = 2e-6f;
            EXPECT_LT(largest_difference(points.p.at(i), si.p), 2 * kNear);
            EXPECT_NEAR(points.p_error[i], si.p_error, 1e-5f * si.p_error);
            EXPECT_LT(largest_difference(points.n.at(i), si.n), kNear);
            EXPECT_LT(largest_difference(points.sn.at(i), si.frame.n), kNear);
            EXPECT_LT(largest_difference(points.s.at(i), si.frame.s), 5 * kNear);
            EXPECT_LT(largest_difference(points.wi.at(i), si.wi), 5 * kNear);
            EXPECT_LT(largest_difference(Vec3(points.uv.at(i), 0), Vec3(si.uv, 0)), kNear);
            EXPECT_EQ(points.primitive[i], si.primitive);
            EXPECT_EQ(points.ray[i], count - 1 - i);
            if (!wants_derivatives) continue;
            EXPECT_LT(largest_difference(points.dp_du.at(i), si.dp_du), 2e-5f);
            EXPECT_LT(largest_difference(points.dp_dv.at(i), si.dp_dv), 2e-5f);
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, InstanceBlocks, testing::ValuesIn(instruction_sets()),
                         [](const auto& test) { return name_of(test.param); });

}  // namespace
}  // namespace kinome::test::instance_block_test
