#include "scene/embree.h"

#include <gtest/gtest.h>

#include <memory>
#include <type_traits>
#include <vector>

#include "support/shape_helpers.h"

/// Compares the packet functions, which replace ray streams for Embree 4, with the batch calls of
/// the installed Embree version.
namespace kinome::test::embree_test {
namespace {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

class EmbreePackets : public testing::Test {
 protected:
  EmbreePackets() : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_.get())) {
    Random random(1);
    for (unsigned i = 0; i < 500; ++i) {
      const Vec3 centre(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
      for (int k = 0; k < 3; ++k) positions_.push_back(centre + 0.2f * random.direction());
      triangles_.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    positions_.reserve(positions_.size() + 2);
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               positions_.data(), 0, sizeof(Vec3), positions_.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               triangles_.data(), 0, sizeof(glm::uvec3), triangles_.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, 7);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_.get());
    for (int i = 0; i < 3001; ++i) {  // not a multiple of 16
      rays_.push_back(ray_hit(3.f * random.direction(), random.direction()));
      rays_.back().ray.d -= rays_.back().ray.o;
      rays_.back().ray.tmax = random.between(0.2f, 3);
    }
  }

  std::vector<Vec3> positions_;
  std::vector<glm::uvec3> triangles_;
  std::vector<RayHit> rays_;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;
};

TEST_F(EmbreePackets, NearestHitsMatchStreamsAndSingleRays) {
  std::vector<RayHit> packets = rays_;
  std::vector<RayHit> stream = rays_;
  std::vector<RayHit> single = rays_;
  embree::Query query(true);
  embree::intersect_packets(scene_.get(), query, packets);
  embree::intersect_stream(scene_.get(), query, stream);
  for (RayHit& ray : single) embree::intersect1(scene_.get(), query, ray);
  size_t hits = 0;
  for (size_t i = 0; i < rays_.size(); ++i) {
    for (const RayHit& other : {stream[i], single[i]}) {
      ASSERT_EQ(packets[i].hit.shape, other.hit.shape) << i;
      ASSERT_NEAR(packets[i].ray.tmax, other.ray.tmax, 1e-5f) << i;
      if (!other.hit.valid()) continue;
      ASSERT_EQ(packets[i].hit.primitive, other.hit.primitive) << i;
      ASSERT_NEAR(packets[i].hit.u, other.hit.u, 1e-3f) << i;
      ASSERT_NEAR(packets[i].hit.v, other.hit.v, 1e-3f) << i;
      ASSERT_LT(glm::length(packets[i].hit.ng - other.hit.ng), 1e-6f) << i;
    }
    hits += packets[i].hit.valid();
    if (packets[i].hit.valid()) {
      ASSERT_EQ(packets[i].hit.shape, 7u);
    }
  }
  EXPECT_GT(hits, 500u);
  EXPECT_LT(hits, 2900u);
}

TEST_F(EmbreePackets, OcclusionEqualsThatOfStreams) {
  std::vector<Ray> packets;
  for (const RayHit& ray : rays_) packets.push_back(ray.ray);
  std::vector<Ray> stream = packets;
  embree::Query query(false);
  embree::occluded_packets(scene_.get(), query, packets);
  embree::occluded_stream(scene_.get(), query, stream);
  for (size_t i = 0; i < rays_.size(); ++i) ASSERT_EQ(packets[i].tmax, stream[i].tmax) << i;
}

}  // namespace
}  // namespace kinome::test::embree_test
