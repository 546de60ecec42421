#include "scene/scene_accelerator.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <exception>
#include <utility>

#include "kinome/error.h"
#include "scene/traceable.h"

namespace kinome {

namespace {

#if defined(__SANITIZE_THREAD__)
constexpr bool kThreadSanitizer = true;
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
constexpr bool kThreadSanitizer = true;
#else
constexpr bool kThreadSanitizer = false;
#endif
#else
constexpr bool kThreadSanitizer = false;
#endif

/// With fewer primitives, trees are built with one thread, because that takes less time than
/// starting threads. Besides, the threads of TBB, which Embree uses, would spin for milliseconds
/// after the build on the cores that the render needs.
constexpr size_t kMinPrimitivesForThreads = 10000;

size_t count_primitives(const std::vector<std::shared_ptr<Shape>>& shapes) {
  size_t primitives = 0;
  for (const auto& shape : shapes) {
    const TriangleMesh* const mesh = shape->mesh();
    const CurveSet* const curves = shape->curves();
    primitives += mesh ? mesh->triangles.size() : curves ? curves->segments.size() : 1;
  }
  return primitives;
}

std::string device_options(size_t primitives, unsigned threads) {
  // ThreadSanitizer can't see the synchronisation inside TBB.
  if (kThreadSanitizer || primitives < kMinPrimitivesForThreads) threads = 1;
  return "threads=" + std::to_string(threads);
}

/// Pads the box by about six ulps. Embree culls with bounds computed in float, and might otherwise
/// lose a surface that lies exactly on its box.
void write_bounds(const Aabb& box, RTCBounds& out) {
  const Vec3 magnitude = glm::max(glm::abs(box.lo), glm::abs(box.hi));
  const Vec3 pad = magnitude * 4e-7f;
  out.lower_x = box.lo.x - pad.x;
  out.lower_y = box.lo.y - pad.y;
  out.lower_z = box.lo.z - pad.z;
  out.upper_x = box.hi.x + pad.x;
  out.upper_y = box.hi.y + pad.y;
  out.upper_z = box.hi.z + pad.z;
}

void bounds_of_shape(const RTCBoundsFunctionArguments* args) {
  write_bounds(static_cast<const Shape*>(args->geometryUserPtr)->bounds(), *args->bounds_o);
}

/// Returns ray i of a packet or stream of n rays.
Ray read_ray(RTCRayN* rays, unsigned n, unsigned i) {
  Ray ray;
  ray.o = {RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)};
  ray.tmin = RTCRayN_tnear(rays, n, i);
  ray.d = {RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)};
  ray.tmax = RTCRayN_tfar(rays, n, i);
  return ray;
}

/// Exception that a shape threw on this thread. Embree would swallow it, and the shape would be
/// missing in the image.
thread_local std::exception_ptr thrown;

bool hit_shape(const Shape& shape, const Ray& ray, float& t, Hit& hit) {
  if (thrown) return false;
  try {
    return shape.intersect(ray, t, hit) && t >= ray.tmin && t <= ray.tmax;
  } catch (...) {
    thrown = std::current_exception();
    return false;
  }
}

bool hit_shape(const Shape& shape, const Ray16& rays, const int* valid, ShapeHit16& hits) {
  if (thrown) return false;
  try {
    shape.intersect_block(rays, valid, hits);
    return true;
  } catch (...) {
    thrown = std::current_exception();
    return false;
  }
}

/// Hits of a packet of 16 rays with a shape. There are no hits if the shape throws.
struct PacketHits {
  PacketHits(const Shape& shape, RTCRayN* rays, const int* valid) {
    if (!hit_shape(shape, *reinterpret_cast<const Ray16*>(rays), valid, hits)) return;
    for (size_t i = 0; i < 16; ++i) {
      is_hit[i] =
          -(static_cast<uint32_t>(valid[i] != 0) & static_cast<uint32_t>(hits.t[i] < kInfinity));
    }
  }
  /// Sets to[i] = value(i) for each ray i with a hit. Uses bit operations, so that compilers
  /// vectorize the loop.
  template <class T, class Value>
  void put(T* to, const Value& value) const {
    for (size_t i = 0; i < 16; ++i) {
      const auto before = std::bit_cast<uint32_t>(to[i]);
      const auto after = std::bit_cast<uint32_t>(value(i));
      to[i] = std::bit_cast<T>((before & ~is_hit[i]) | (after & is_hit[i]));
    }
  }

  ShapeHit16 hits{};
  alignas(64) uint32_t is_hit[16] = {};  ///< all bits set, or none
};

/// Calls fn(i, t, hit) for each of n rays that hits the shape.
template <class Function>
void for_each_hit(const Shape& shape, RTCRayN* rays, const int* valid, unsigned n,
                  const Function& fn) {
  for (unsigned i = 0; i < n; ++i) {
    if (valid[i] == 0) continue;
    float t = 0;
    Hit hit;
    if (hit_shape(shape, read_ray(rays, n, i), t, hit)) fn(i, t, hit);
  }
}

void intersect_shape(const RTCIntersectFunctionNArguments* args) {
  const Shape& shape = *static_cast<const Shape*>(args->geometryUserPtr);
  const unsigned n = args->N, id = args->geomID, instance = args->context->instID[0];
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, n);
  if (n == 16) {
    const PacketHits found(shape, rays, args->valid);
    const ShapeHit16& from = found.hits;
    auto& to = *reinterpret_cast<RayHit16*>(args->rayhit);
    found.put(to.ray.tmax, [&](size_t i) { return from.t[i]; });
    found.put(to.ngx, [&](size_t i) { return from.ngx[i]; });
    found.put(to.ngy, [&](size_t i) { return from.ngy[i]; });
    found.put(to.ngz, [&](size_t i) { return from.ngz[i]; });
    found.put(to.u, [&](size_t i) { return from.u[i]; });
    found.put(to.v, [&](size_t i) { return from.v[i]; });
    found.put(to.primitive, [&](size_t i) { return from.primitive[i]; });
    found.put(to.shape, [&](size_t) { return id; });
    found.put(to.instance, [&](size_t) { return instance; });
    return;
  }
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, n);
  for_each_hit(shape, rays, args->valid, n, [&](unsigned i, float t, const Hit& hit) {
    RTCRayN_tfar(rays, n, i) = t;
    RTCHitN_Ng_x(hits, n, i) = hit.ng.x;
    RTCHitN_Ng_y(hits, n, i) = hit.ng.y;
    RTCHitN_Ng_z(hits, n, i) = hit.ng.z;
    RTCHitN_u(hits, n, i) = hit.u;
    RTCHitN_v(hits, n, i) = hit.v;
    RTCHitN_primID(hits, n, i) = hit.primitive == kNoHit ? args->primID : hit.primitive;
    RTCHitN_geomID(hits, n, i) = id;
    RTCHitN_instID(hits, n, i, 0) = instance;
  });
}

void occlude_by_shape(const RTCOccludedFunctionNArguments* args) {
  const Shape& shape = *static_cast<const Shape*>(args->geometryUserPtr);
  const unsigned n = args->N;
  if (n == 16) {
    PacketHits(shape, args->ray, args->valid)
        .put(reinterpret_cast<Ray16*>(args->ray)->tmax, [](size_t) { return -kInfinity; });
    return;
  }
  for_each_hit(shape, args->ray, args->valid, n,
               [&](unsigned i, float, const Hit&) { RTCRayN_tfar(args->ray, n, i) = -kInfinity; });
}

/// Filter function that rejects hits with curves from inside.
void reject_inside(const RTCFilterFunctionNArguments* args) {
  const unsigned n = args->N;
  for (unsigned i = 0; i < n; ++i) {
    const Vec3 outward(RTCHitN_Ng_x(args->hit, n, i), RTCHitN_Ng_y(args->hit, n, i),
                       RTCHitN_Ng_z(args->hit, n, i));
    const Vec3 d(RTCRayN_dir_x(args->ray, n, i), RTCRayN_dir_y(args->ray, n, i),
                 RTCRayN_dir_z(args->ray, n, i));
    if (glm::dot(outward, d) > 0) args->valid[i] = 0;
  }
}

/// Returns why creating a device failed. Embree's unknown errors may be a lack of memory as well,
/// for example for a thread.
Error device_error() {
  switch (rtcGetDeviceError(nullptr)) {
    case RTC_ERROR_OUT_OF_MEMORY:
      return Error("the ray tracer (Embree) can't start: out of memory");
    case RTC_ERROR_UNSUPPORTED_CPU:
      return Error(
          "the ray tracer (Embree) can't start: this processor lacks instructions that it needs");
    default:
      return Error(
          "the ray tracer (Embree) can't start: out of memory, or it doesn't support this "
          "machine");
  }
}

}  // namespace

void rethrow_from_shapes() {
  if (thrown) std::rethrow_exception(std::exchange(thrown, nullptr));
}

void DeviceErrors::report(void* self, RTCError code, const char* text) {
  auto& errors = *static_cast<DeviceErrors*>(self);
  const std::lock_guard lock(errors.mutex_);
  if (errors.message_.empty() && code == RTC_ERROR_OUT_OF_MEMORY) errors.message_ = "out of memory";
  if (errors.message_.empty()) errors.message_ = text && *text ? text : "unknown error";
}

void DeviceErrors::throw_if_any() const {
  const std::lock_guard lock(mutex_);
  if (!message_.empty()) throw Error("the ray tracer (Embree) failed: " + message_);
}

Scene::Accelerator::Accelerator(const Contents& contents, const std::vector<Placed>& placed,
                                unsigned threads) {
  size_t primitives = count_primitives(contents.shapes);
  std::vector<const ShapeInstance*> instances;
  for (const Placed& at : placed) {
    const ShapeGroup& group = at.instance->group();
    instances.push_back(at.instance.get());
    if (groups_.emplace(&group, nullptr).second) primitives += count_primitives(group.shapes());
  }
  max_coordinate_ = max_ray_coordinate(instances);
  device_.reset(rtcNewDevice(device_options(primitives, threads).c_str()));
  if (!device_) throw device_error();
  rtcSetDeviceErrorFunction(device_.get(), &DeviceErrors::report, &errors_);
  for (auto& [group, scene] : groups_) {
    scene = new_scene(contents.watertight);
    const auto& shapes = group->shapes();
    for (size_t i = 0; i < shapes.size(); ++i) attach(scene.get(), make_geometry(*shapes[i]), i);
    rtcCommitScene(scene.get());
    errors_.throw_if_any();
  }
  scene_ = new_scene(contents.watertight);
  auto next = placed.begin();
  for (size_t i = 0; i < contents.shapes.size();) {
    if (next != placed.end() && next->first == i) {
      const ShapeGroup& group = next->instance->group();
      attach(scene_.get(), make_instance(groups_.at(&group).get(), next->instance->to_world()), i);
      i += group.shapes().size();
      ++next;
    } else {
      attach(scene_.get(), make_geometry(*contents.shapes[i]), i);
      ++i;
    }
  }
  rtcCommitScene(scene_.get());
  errors_.throw_if_any();
}

Scene::Accelerator::SceneHandle Scene::Accelerator::new_scene(bool watertight) const {
  SceneHandle scene(rtcNewScene(device_.get()));
  errors_.throw_if_any();
  rtcSetSceneFlags(scene.get(), watertight ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  return scene;
}

void Scene::Accelerator::attach(RTCScene scene, const Geometry& geometry, size_t id) const {
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene, geometry.get(), static_cast<unsigned>(id));
  errors_.throw_if_any();
}

Scene::Accelerator::Geometry Scene::Accelerator::new_geometry(RTCGeometryType type) const {
  Geometry geometry(rtcNewGeometry(device_.get(), type));
  errors_.throw_if_any();
  return geometry;
}

Scene::Accelerator::Geometry Scene::Accelerator::make_geometry(const Shape& shape) const {
  if (const TriangleMesh* const mesh = shape.mesh()) return make_mesh(*mesh);
  if (const CurveSet* const curves = shape.curves()) return make_curves(*curves);
  return make_analytic(shape);
}

Scene::Accelerator::Geometry Scene::Accelerator::make_instance(RTCScene group,
                                                               const Mat4& to_world) const {
  Geometry geometry = new_geometry(RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry.get(), group);
  rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &to_world[0][0]);
  return geometry;
}

/// Copies the control points to Embree. Hits from inside are always culled, as in Mitsuba; without
/// the filter, this would depend on Embree's build options.
Scene::Accelerator::Geometry Scene::Accelerator::make_curves(const CurveSet& curves) const {
  Geometry geometry = new_geometry(curves.is_bspline ? RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE
                                                     : RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
  const auto fill = [&](RTCBufferType type, RTCFormat format, const auto& values) {
    const size_t size = sizeof(values[0]);
    void* const copy =
        rtcSetNewGeometryBuffer(geometry.get(), type, 0, format, size, values.size());
    if (copy) std::memcpy(copy, values.data(), values.size() * size);
  };
  fill(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, curves.points);
  fill(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, curves.segments);
  rtcSetGeometryIntersectFilterFunction(geometry.get(), &reject_inside);
  rtcSetGeometryOccludedFilterFunction(geometry.get(), &reject_inside);
  return geometry;
}

Scene::Accelerator::Geometry Scene::Accelerator::make_mesh(const TriangleMesh& mesh) const {
  Geometry geometry = new_geometry(RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto& positions = mesh.positions;
  // Embree loads vertices 16 bytes at a time, so 4 bytes past the last one must be readable.
  // MeshShape::finish() reserves them. Other meshes may not have them, and are copied.
  if (positions.capacity() > positions.size()) {
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               positions.data(), 0, sizeof(Vec3), positions.size());
  } else if (void* copy =
                 rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0,
                                         RTC_FORMAT_FLOAT3, sizeof(Vec3), positions.size())) {
    std::memcpy(copy, positions.data(), positions.size() * sizeof(Vec3));
  }
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.triangles.data(), 0, sizeof(glm::uvec3), mesh.triangles.size());
  return geometry;
}

Scene::Accelerator::Geometry Scene::Accelerator::make_analytic(const Shape& shape) const {
  Geometry geometry = new_geometry(RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
  rtcSetGeometryUserData(geometry.get(), const_cast<Shape*>(&shape));
  rtcSetGeometryBoundsFunction(geometry.get(), &bounds_of_shape, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), &intersect_shape);
  rtcSetGeometryOccludedFunction(geometry.get(), &occlude_by_shape);
  return geometry;
}

}  // namespace kinome
