#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <vector>

#include "kinome/scene.h"
#include "scene/embree.h"

namespace kinome {

/// What a device told its error callback; the first message counts, later ones are consequences.
class DeviceErrors {
 public:
  static void report(void* self, RTCError code, const char* text);
  void throw_if_any() const;

 private:
  mutable std::mutex mutex_;  // the callback may come from any thread of a build
  std::string message_;
};

/// After queries: throws what shapes threw within them on this thread.
void rethrow_from_shapes();

/// Embree's device and scene: one geometry for each shape, with the shape's index as its id.
struct Scene::Accelerator {
  Accelerator(const Contents& contents, unsigned threads);
  RTCScene scene() const { return scene_.get(); }

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
  Geometry make_mesh(const TriangleMesh& mesh) const;
  Geometry make_analytic(const Shape& shape) const;

  // The scene goes before the device, and the device before what its callback writes to.
  DeviceErrors errors_;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene> scene_;
};

}  // namespace kinome
