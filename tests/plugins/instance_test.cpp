// Tests that instances equal moved copies of their group's shapes.

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>

#include "kinome/block_points.h"
#include "kinome/texture.h"
#include "support/shape_helpers.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

namespace kinome::test::instance_test {
namespace {

std::string moved(const std::string& operations) {
  return "<transform name='to_world'>" + operations + "</transform>";
}
std::string group_of(const std::string& shapes) {
  return "<shape type='shapegroup' id='group'>" + shapes + "</shape>";
}
std::string instance(const std::string& operations) {
  return "<shape type='instance'><ref id='group'/>" + moved(operations) + "</shape>";
}

constexpr const char* kObj = R"(
v -1 -1 0
v 1 -1 .3
v 1 1 -.2
v -1 1 .4
v 0 0 1
vt 0 0
vt 1 .1
vt .9 1
vt 0 .8
vt .5 .5
vn -.3 -.3 .9
vn .4 -.2 .9
vn .3 .3 .9
vn -.2 .4 .9
vn 0 0 1
f 1/1/1 2/2/2 5/5/5
f 2/2/2 3/3/3 5/5/5
f 3/3/3 4/4/4 5/5/5
f 4/4/4 1/1/1 5/5/5
)";

class Instances : public testing::Test {
 protected:
  /// Returns a shape of this type with the children `inside`.
  std::string shape(const std::string& type, const std::string& inside) const {
    const std::string file =
        type == "obj" ? "<string name='filename' value='" + obj_ + "'/>" : std::string();
    return "<shape type='" + type + "'>" + file + inside + "</shape>";
  }

 private:
  TemporaryFolder folder_;
  std::string obj_ = folder_.write("a.obj", kObj);
};

constexpr const char* kSimilar =
    "<scale value='1.7'/><rotate x='.36' y='.48' z='.8' angle='50'/><translate x='3' y='-2' "
    "z='.5'/>";
constexpr const char* kAffine = "<matrix value='1.5 .3 .2 3  0 .8 -.4 -2  .1 0 .6 .5  0 0 0 1'/>";
constexpr const char* kTurnedMirror =
    "<scale x='-1.7' y='1.7' z='1.7'/><rotate x='.36' y='.48' z='.8' angle='50'/>"
    "<translate x='3' y='-2' z='.5'/>";
constexpr const char* kMirrored =
    "<matrix value='-1.5 .3 .2 3  0 .8 -.4 -2  .1 0 .6 .5  0 0 0 1'/>";

void expect_near(const SurfaceInteraction& a, const SurfaceInteraction& b) {
  const auto near = [](const Vec3& x, const Vec3& y) {
    EXPECT_LT(glm::length(x - y), 5e-5f * std::max(1.f, glm::length(y)));
  };
  EXPECT_NEAR(a.t, b.t, 1e-5f * b.t);
  near(a.p, b.p), near(a.n, b.n), near(a.dp_du, b.dp_du), near(a.dp_dv, b.dp_dv);
  near(a.frame.n, b.frame.n), near(a.frame.s, b.frame.s), near(a.frame.t, b.frame.t);
  near(a.wi, b.wi), near(Vec3(a.uv, 0), Vec3(b.uv, 0));
  EXPECT_EQ(a.primitive, b.primitive);
}

/// Under non-uniform scaling, the normals of an instance and of a moved mesh differ. Those of an
/// instance are interpolated before they are transformed, as in Mitsuba.
TEST_F(Instances, AreWhatTheMovedShapeIs) {
  const std::pair<const char*, const char*> cases[] = {
      {"sphere", kSimilar},   {"cylinder", kSimilar}, {"cube", kAffine},      {"disk", kAffine},
      {"rectangle", kAffine}, {"obj", kSimilar},      {"obj", kTurnedMirror},
  };
  for (const auto& [type, operations] : cases) {
    SCOPED_TRACE(std::string(type) + operations);
    const auto plain = scene_from(shape(type, moved(operations)));
    const auto scene = scene_from(group_of(shape(type, "")) + instance(operations));
    ASSERT_EQ(scene->shapes().size(), 1u);
    EXPECT_EQ(scene->shapes()[0]->mesh(), nullptr);
    EXPECT_LE(scene->bounds().lo.x, plain->bounds().lo.x + 1e-4f);
    EXPECT_GE(scene->bounds().hi.z, plain->bounds().hi.z - 1e-4f);
    Random random(1);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 target = Vec3(3, -2, .5f) + 2.f * random.unit() * random.direction();
      const Vec3 o = Vec3(3, -2, .5f) + 9.f * random.direction();
      const RayHit expected = trace(*plain, o, target - o), hit = trace(*scene, o, target - o);
      // At edges, rounding decides which primitive is hit.
      if (!expected.hit.valid() || !hit.hit.valid()) continue;
      if (std::abs(expected.ray.tmax - hit.ray.tmax) > 1e-3f) continue;
      if (expected.hit.primitive != hit.hit.primitive) continue;
      ++hits;
      EXPECT_EQ(hit.hit.shape, 0u);
      const SurfaceInteraction si = plain->interaction(expected);
      // Near its centre, the direction of a disk's frame is numerically unstable.
      if (std::string(type) == "disk" && si.uv.x < 0.2f) continue;
      expect_near(scene->interaction(hit), si);
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_GT(hits, 500);
  }
}

TEST_F(Instances, AreMetAsOftenAsTheMovedShape) {
  for (const char* type : {"cube", "obj", "disk"}) {
    const auto plain = scene_from(shape(type, moved(kAffine)));
    const auto scene = scene_from(group_of(shape(type, "")) + instance(kAffine));
    Random random(2);
    std::vector<RayHit> a, b;
    std::vector<Ray> shadow_a, shadow_b;
    for (int i = 0; i < 5000; ++i) {
      const Vec3 o = Vec3(3, -2, .5f) + 9.f * random.direction();
      a.push_back(ray_hit(o, Vec3(3, -2, .5f) + 3.f * random.direction() - o));
      shadow_a.push_back(a.back().ray);
    }
    b = a, shadow_b = shadow_a;
    RenderCounters counters;
    for (const Coherence coherence : {Coherence::kCoherent, Coherence::kIncoherent}) {
      auto hits_a = a, hits_b = b;
      plain->intersect(hits_a, coherence, counters);
      scene->intersect(hits_b, coherence, counters);
      auto dark_a = shadow_a, dark_b = shadow_b;
      plain->occluded(dark_a, coherence, counters);
      scene->occluded(dark_b, coherence, counters);
      int differ = 0, hits = 0;
      for (size_t i = 0; i < a.size(); ++i) {
        hits += hits_a[i].hit.valid();
        differ += hits_a[i].hit.valid() != hits_b[i].hit.valid();
        differ += dark_a[i].is_occluded() != dark_b[i].is_occluded();
        EXPECT_EQ(hits_b[i].hit.valid(), dark_b[i].is_occluded());
      }
      EXPECT_GT(hits, 100);
      EXPECT_LE(differ, 4);  // at edges
    }
  }
}

/// Traces two instances of a group of two shapes, and shapes around them. The shape index of a hit
/// must be its index in Scene::shapes() for all ways to trace.
TEST_F(Instances, TellWhichPartWasMet) {
  const std::string near = shape("disk", ""), far = shape("cube", moved("<translate x='5'/>"));
  const auto scene =
      scene_from(shape("sphere", moved("<translate y='30'/>")) + group_of(near + far) +
                 instance("<translate y='10'/>") + instance("<translate y='20'/>") +
                 shape("disk", moved("<translate y='40'/>")));
  ASSERT_EQ(scene->shapes().size(), 6u);
  const Vec3 targets[] = {{0, 30, 0}, {0, 10, 0}, {5, 10, 0}, {0, 20, 0}, {5, 20, 0}, {0, 40, 0}};
  RayHit16 packet{};
  reset(packet.ray);
  std::fill_n(packet.shape, 16, kNoHit), std::fill_n(packet.instance, 16, kNoHit);
  std::fill_n(packet.ray.tmax, 16, -1.f);
  std::vector<RayHit> stream;
  for (uint32_t i = 0; i < 6; ++i) {
    const Vec3 o = targets[i] + Vec3(.1f, .2f, 7), d(0, 0, -1);
    EXPECT_EQ(trace(*scene, o, d).hit.shape, i);
    EXPECT_EQ(scene->interaction(trace(*scene, o, d)).shape, scene->shapes()[i].get());
    stream.push_back(ray_hit(o, d));
    Columns3{packet.ray.ox, packet.ray.oy, packet.ray.oz}.set(i, o);
    Columns3{packet.ray.dx, packet.ray.dy, packet.ray.dz}.set(i, d);
    packet.ray.tmax[i] = kInfinity;
  }
  RenderCounters counters;
  scene->intersect(stream, Coherence::kCoherent, counters);
  scene->intersect(&packet, 1, Coherence::kIncoherent, counters);
  for (uint32_t i = 0; i < 6; ++i) {
    EXPECT_EQ(stream[i].hit.shape, i);
    EXPECT_EQ(packet.shape[i], i);
  }
  EXPECT_EQ(packet.shape[6], kNoHit);
}

TEST_F(Instances, HaveTheMaterialsOfTheirGroup) {
  const auto scene =
      scene_from(group_of(shape("disk", "<bsdf type='diffuse' id='grey'/>") + shape("sphere", "")) +
                 instance("") + instance("<scale value='2'/>"));
  ASSERT_EQ(scene->shapes().size(), 4u);
  EXPECT_EQ(scene->shapes()[0]->bsdf_pointer(), scene->shapes()[2]->bsdf_pointer());
  EXPECT_EQ(scene->shapes()[0]->bsdf().id(), "grey");
  EXPECT_NE(scene->shapes()[0]->bsdf_pointer(), scene->shapes()[1]->bsdf_pointer());
}

/// Also under non-uniform scaling, and far from the origin.
TEST_F(Instances, AreNotMetByRaysThatLeaveThem) {
  const char* const maps[] = {
      kSimilar,
      kAffine,
      kMirrored,
      "<scale value='1e-4'/>",
      "<scale value='1e4'/>",
      "<scale x='20' y='1' z='.05'/>",
      "<scale x='3' y='1' z='2'/><rotate x='.36' y='.48' z='.8' angle='50'/>"
      "<translate x='1e5' y='-1e5' z='1e4'/>"};
  for (const char* type : {"sphere", "cube", "disk"}) {
    for (const char* operations : maps) {
      SCOPED_TRACE(std::string(type) + operations);
      const auto scene = scene_from(group_of(shape(type, "")) + instance(operations));
      const Vec3 centre = scene->bounds().centre();
      const Vec3 reach = 0.5f * scene->bounds().extent();
      Random random(3);
      std::vector<RayHit> leaving;
      for (int i = 0; i < 5000; ++i) {
        const Vec3 target = centre + reach * 0.7f * random.direction();
        const Vec3 o = centre + 3 * max_component(reach) * random.direction();
        const RayHit hit = trace(*scene, o, glm::normalize(target - o));
        if (!hit.hit.valid()) continue;
        const SurfaceInteraction si = scene->interaction(hit);
        const float side = glm::dot(si.n, o - si.p) > 0 ? 1.f : -1.f;
        const Vec3 d = grazing_direction(random, si.n * side, -3);
        leaving.push_back(ray_hit(si.ray_origin(d), d));
      }
      EXPECT_GT(leaving.size(), 500u);
      EXPECT_EQ(count_hits(*scene, leaving), 0);
    }
  }
}

TEST_F(Instances, HaveTheAreaOfTheMovedShapeAndAreSampledEvenly) {
  Random random(4);
  for (const char* type : {"obj", "cube", "disk"}) {
    SCOPED_TRACE(type);
    const auto plain = scene_from(shape(type, moved(kAffine)));
    const auto scene = scene_from(group_of(shape(type, "")) + instance(kAffine));
    const Shape& a = *plain->shapes()[0];
    const Shape& b = *scene->shapes()[0];
    EXPECT_NEAR(b.area(), a.area(), 1e-5f * a.area());
    // Compares the means of the position and of its squares: six tests at 5 standard deviations.
    glm::dvec3 mean_a(0), mean_b(0), squares(0), more_a(0), more_b(0), fourths(0);
    constexpr int kCount = 40000;
    for (int i = 0; i < kCount; ++i) {
      Vec2 u;
      u.x = random.unit(), u.y = random.unit();
      const glm::dvec3 p(a.sample_surface(u).p - Vec3(3, -2, .5f));
      const SurfaceInteraction si = b.sample_surface(u);
      const glm::dvec3 q(si.p - Vec3(3, -2, .5f));
      EXPECT_EQ(si.shape, &b);
      mean_a += p, mean_b += q, squares += p * p, more_a += p * p, more_b += q * q;
      fourths += p * p * p * p;
    }
    for (int k = 0; k < 3; ++k) {
      const double error = std::sqrt(2 * squares[k]);
      EXPECT_NEAR(mean_a[k], mean_b[k], 5 * error);
      EXPECT_NEAR(more_a[k], more_b[k], 5 * std::sqrt(2 * fourths[k]));
    }
  }
  // An oblate spheroid: 2 pi a² (1 + (1 - e²) / e artanh e), e² = 1 - c² / a².
  const auto scene =
      scene_from(group_of(shape("sphere", "")) + instance("<scale x='2' y='2' z='.7'/>"));
  const double e = std::sqrt(1 - .7 * .7 / 4);
  EXPECT_NEAR(scene->shapes()[0]->area(),
              8 * std::numbers::pi * (1 + (1 - e * e) / e * std::atanh(e)), 1e-2);
}

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

TEST_F(Instances, SayWhatIsWrong) {
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

TEST_F(Instances, MergesAreTheirShapes) {
  const auto scene =
      scene_from(group_of("<shape type='merge'><shape type='disk'/><shape type='cube'/></shape>") +
                 "<shape type='merge'><shape type='sphere'/>"
                 "<shape type='cube'><emitter type='area'/></shape>" +
                 instance("<translate x='9'/>") + "</shape>");
  ASSERT_EQ(scene->shapes().size(), 4u);
  EXPECT_EQ(trace(*scene, {9, 0, 9}, {0, 0, -1}).hit.shape, 3u);
  EXPECT_TRUE(scene->shapes()[1]->emitter());
  EXPECT_EQ(scene->emitters().size(), 1u);
}

size_t resident_bytes() {
  std::ifstream in("/proc/self/statm");
  size_t all = 0, resident = 0;
  in >> all >> resident;
  return resident * 4096;
}

/// A mesh of 10^5 triangles takes some 10 MB with its BVH; 10,000 copies would take 100 GB.
TEST_F(Instances, TakeNoMemoryForWhatTheyShow) {
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

TEST_P(InstanceBlocks, AreThoseOfPoints) {
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
}  // namespace kinome::test::instance_test
