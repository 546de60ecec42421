#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <vector>

#include "kinome/scene.h"
#include "scene/embree.h"

namespace kinome {

/// Errors that a device reported to its callback. Only the first message is kept, because later
/// errors are consequences.
class DeviceErrors {
 public:
  static void report(void* self, RTCError code, const char* text);
  void throw_if_any() const;

 private:
  mutable std::mutex mutex_;  // the callback may come from any thread of a build
  std::string message_;
};

/// Rethrows an exception that a shape threw on this thread during a query. Exported for the copy of
/// scene.cpp in tests/defects.
KINOME_EXPORT void rethrow_from_shapes();

/// Embree's device and scene. Each shape is a geometry whose id is the shape's index. All parts of
/// an instance are one geometry, whose id is the index of the first part. Each group with instances
/// has a scene of its own.
struct Scene::Accelerator {
  Accelerator(const Contents& contents, const std::vector<Placed>& placed, unsigned threads);
  RTCScene scene() const { return scene_.get(); }
  /// Largest component that origins and directions of rays may have (see max_ray_coordinate()).
  float max_coordinate() const { return max_coordinate_; }

 private:
  struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };
  struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  struct ReleaseGeometry {
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
  };
  using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, ReleaseGeometry>;
  using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;
  Geometry new_geometry(RTCGeometryType type) const;
  Geometry make_geometry(const Shape& shape) const;
  Geometry make_mesh(const TriangleMesh& mesh) const;
  Geometry make_curves(const CurveSet& curves) const;
  Geometry make_analytic(const Shape& shape) const;
  Geometry make_instance(RTCScene group, const Mat4& to_world) const;
  SceneHandle new_scene(bool watertight) const;
  void attach(RTCScene scene, const Geometry& geometry, size_t id) const;

  // The order of destruction matters: scenes before the device, and the device before errors_, to
  // which its callback writes.
  DeviceErrors errors_;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  std::map<const ShapeGroup*, SceneHandle> groups_;
  SceneHandle scene_;
  float max_coordinate_;
};

}  // namespace kinome
