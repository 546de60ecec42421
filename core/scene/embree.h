#pragma once

/// Hides the differences between Embree 3 and 4. They pass the options of a query differently,
/// their RTCHit differs, and version 4 has no ray streams; this header uses packets of 16 instead.
#if KINOME_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cstddef>
#include <span>

#include "kinome/blocks.h"
#include "kinome/ray.h"

namespace kinome::embree {

// Ray has the layout of RTCRay in both versions.
static_assert(sizeof(Ray) == sizeof(RTCRay) && alignof(Ray) == alignof(RTCRay));
static_assert(offsetof(Ray, o) == offsetof(RTCRay, org_x));
static_assert(offsetof(Ray, tmin) == offsetof(RTCRay, tnear));
static_assert(offsetof(Ray, d) == offsetof(RTCRay, dir_x));
static_assert(offsetof(Ray, time) == offsetof(RTCRay, time));
static_assert(offsetof(Ray, tmax) == offsetof(RTCRay, tfar));
static_assert(offsetof(Ray, mask) == offsetof(RTCRay, mask));
static_assert(offsetof(Ray, id) == offsetof(RTCRay, id));
static_assert(offsetof(Ray, flags) == offsetof(RTCRay, flags));
static_assert(kNoHit == RTC_INVALID_GEOMETRY_ID);

// Ray16 and RayHit16 have the layouts of RTCRay16 and RTCRayHit16, which may be shorter.
static_assert(sizeof(Ray16) == sizeof(RTCRay16) && alignof(Ray16) >= alignof(RTCRay16));
static_assert(offsetof(Ray16, ox) == offsetof(RTCRay16, org_x));
static_assert(offsetof(Ray16, tmin) == offsetof(RTCRay16, tnear));
static_assert(offsetof(Ray16, dx) == offsetof(RTCRay16, dir_x));
static_assert(offsetof(Ray16, time) == offsetof(RTCRay16, time));
static_assert(offsetof(Ray16, tmax) == offsetof(RTCRay16, tfar));
static_assert(offsetof(Ray16, mask) == offsetof(RTCRay16, mask));
static_assert(offsetof(Ray16, id) == offsetof(RTCRay16, id));
static_assert(offsetof(Ray16, flags) == offsetof(RTCRay16, flags));
static_assert(sizeof(RayHit16) >= sizeof(RTCRayHit16) && alignof(RayHit16) >= alignof(RTCRayHit16));
static_assert(offsetof(RayHit16, ngx) == offsetof(RTCRayHit16, hit.Ng_x));
static_assert(offsetof(RayHit16, u) == offsetof(RTCRayHit16, hit.u));
static_assert(offsetof(RayHit16, v) == offsetof(RTCRayHit16, hit.v));
static_assert(offsetof(RayHit16, primitive) == offsetof(RTCRayHit16, hit.primID));
static_assert(offsetof(RayHit16, shape) == offsetof(RTCRayHit16, hit.geomID));
static_assert(offsetof(RayHit16, instance) == offsetof(RTCRayHit16, hit.instID));

#if KINOME_EMBREE_MAJOR >= 4

/// Options of nearest-hit and any-hit queries.
struct Query {
  explicit Query(bool coherent) {
    rtcInitIntersectArguments(&intersect);
    rtcInitOccludedArguments(&occluded);
    const RTCRayQueryFlags flags =
        coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    intersect.flags = flags;
    occluded.flags = flags;
  }
  RTCIntersectArguments intersect;
  RTCOccludedArguments occluded;
};

inline void intersect16(const int* valid, RTCScene scene, Query& query, RTCRayHit16& rays) {
  rtcIntersect16(valid, scene, &rays, &query.intersect);
}
inline void occluded16(const int* valid, RTCScene scene, Query& query, RTCRay16& rays) {
  rtcOccluded16(valid, scene, &rays, &query.occluded);
}

/// Copies the hit, because RTCHit may be longer than Hit in Embree 4 (instance arrays).
inline void intersect1(RTCScene scene, Query& query, RayHit& ray) {
  RTCRayHit r;
  r.ray = reinterpret_cast<const RTCRay&>(ray.ray);
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene, &r, &query.intersect);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  ray.ray.tmax = r.ray.tfar;
  ray.hit = {{r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z},
             r.hit.u,
             r.hit.v,
             r.hit.primID,
             r.hit.geomID,
             r.hit.instID[0]};
}

#else

// Batches are passed to Embree without a copy.
static_assert(sizeof(Hit) == sizeof(RTCHit) && alignof(Hit) == alignof(RTCHit));
static_assert(offsetof(Hit, ng) == offsetof(RTCHit, Ng_x));
static_assert(offsetof(Hit, u) == offsetof(RTCHit, u));
static_assert(offsetof(Hit, v) == offsetof(RTCHit, v));
static_assert(offsetof(Hit, primitive) == offsetof(RTCHit, primID));
static_assert(offsetof(Hit, shape) == offsetof(RTCHit, geomID));
static_assert(offsetof(Hit, instance) == offsetof(RTCHit, instID));
static_assert(sizeof(RayHit) == sizeof(RTCRayHit) && alignof(RayHit) == alignof(RTCRayHit));
static_assert(offsetof(RayHit, hit) == offsetof(RTCRayHit, hit));

struct Query {
  explicit Query(bool coherent) {
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  }
  RTCIntersectContext context;
};

inline void intersect16(const int* valid, RTCScene scene, Query& query, RTCRayHit16& rays) {
  rtcIntersect16(valid, scene, &query.context, &rays);
}
inline void occluded16(const int* valid, RTCScene scene, Query& query, RTCRay16& rays) {
  rtcOccluded16(valid, scene, &query.context, &rays);
}
inline void intersect1(RTCScene scene, Query& query, RayHit& ray) {
  rtcIntersect1(scene, &query.context, reinterpret_cast<RTCRayHit*>(&ray));
}

#endif

/// Copies a ray to a lane of a packet.
inline void load_packet(const Ray& ray, RTCRay16& packet, size_t lane) {
  packet.org_x[lane] = ray.o.x;
  packet.org_y[lane] = ray.o.y;
  packet.org_z[lane] = ray.o.z;
  packet.tnear[lane] = ray.tmin;
  packet.dir_x[lane] = ray.d.x;
  packet.dir_y[lane] = ray.d.y;
  packet.dir_z[lane] = ray.d.z;
  packet.time[lane] = ray.time;
  packet.tfar[lane] = ray.tmax;
  packet.mask[lane] = ray.mask;
  packet.id[lane] = ray.id;
  packet.flags[lane] = ray.flags;
}

inline void intersect_packets(RTCScene scene, Query& query, std::span<RayHit> rays) {
  for (size_t first = 0; first < rays.size(); first += 16) {
    const size_t count = std::min<size_t>(16, rays.size() - first);
    alignas(64) int valid[16] = {};
    RTCRayHit16 packet{};
    for (size_t i = 0; i < count; ++i) {
      valid[i] = -1;
      load_packet(rays[first + i].ray, packet.ray, i);
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    intersect16(valid, scene, query, packet);
    for (size_t i = 0; i < count; ++i) {
      if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      RayHit& r = rays[first + i];
      r.ray.tmax = packet.ray.tfar[i];
      r.hit = {{packet.hit.Ng_x[i], packet.hit.Ng_y[i], packet.hit.Ng_z[i]},
               packet.hit.u[i],
               packet.hit.v[i],
               packet.hit.primID[i],
               packet.hit.geomID[i],
               packet.hit.instID[0][i]};
    }
  }
}

inline void occluded_packets(RTCScene scene, Query& query, std::span<Ray> rays) {
  for (size_t first = 0; first < rays.size(); first += 16) {
    const size_t count = std::min<size_t>(16, rays.size() - first);
    alignas(64) int valid[16] = {};
    RTCRay16 packet{};
    for (size_t i = 0; i < count; ++i) {
      valid[i] = -1;
      load_packet(rays[first + i], packet, i);
    }
    occluded16(valid, scene, query, packet);
    for (size_t i = 0; i < count; ++i) rays[first + i].tmax = packet.tfar[i];
  }
}

#if KINOME_EMBREE_MAJOR >= 4

inline void intersect_stream(RTCScene scene, Query& query, std::span<RayHit> rays) {
  intersect_packets(scene, query, rays);
}
inline void occluded_stream(RTCScene scene, Query& query, std::span<Ray> rays) {
  occluded_packets(scene, query, rays);
}

#else

inline void intersect_stream(RTCScene scene, Query& query, std::span<RayHit> rays) {
  rtcIntersect1M(scene, &query.context, reinterpret_cast<RTCRayHit*>(rays.data()),
                 static_cast<unsigned>(rays.size()), sizeof(RayHit));
}
inline void occluded_stream(RTCScene scene, Query& query, std::span<Ray> rays) {
  rtcOccluded1M(scene, &query.context, reinterpret_cast<RTCRay*>(rays.data()),
                static_cast<unsigned>(rays.size()), sizeof(Ray));
}

#endif

}  // namespace kinome::embree
