#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kinome/emitter.h"
#include "kinome/integrator.h"
#include "kinome/medium.h"
#include "kinome/ray.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/shape_group.h"
#include "kinome/stats.h"

namespace kinome {

/// Coherence of a batch of rays, a hint for the ray tracer.
enum class Coherence { kIncoherent, kCoherent };

/// Scene to render. Immutable once built, and thread-safe.
class KINOME_EXPORT Scene {
 public:
  struct Contents {
    std::vector<std::shared_ptr<Shape>> shapes;
    std::vector<std::shared_ptr<Emitter>> emitters;  ///< emitters that are not part of a shape
    std::vector<std::shared_ptr<Sensor>> sensors;
    std::shared_ptr<Integrator> integrator;
    std::string file;
    std::string hash;  ///< hash of the scene file's text with includes and -D; 16 hex digits
    /// True if no ray may pass between two triangles that share an edge. Otherwise rays are about
    /// 10 % faster, but about one in a million passes through a finely tessellated surface.
    bool watertight = true;
  };
  /// Builds the acceleration structure with `threads` threads. Every shape must have a BSDF. Reuses
  /// the structure of `before` if that has exactly the same shapes; their geometry must not have
  /// changed since.
  Scene(Contents contents, unsigned threads, const Scene* before = nullptr);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Shapes that rays can hit. A shape with parts is replaced by its parts, in order.
  const std::vector<std::shared_ptr<Shape>>& shapes() const { return contents_.shapes; }
  /// All emitters except indirect ones, including nested emitters and those of shapes.
  const std::vector<const Emitter*>& emitters() const { return emitters_; }
  /// Emitters that represent the bounce of others (Emitter::is_indirect()).
  const std::vector<const Emitter*>& indirect_emitters() const { return indirect_emitters_; }
  /// The environment, or nullptr if there is none.
  const Emitter* environment() const { return environment_; }
  /// True if a shape emits light. Rays that look for light then need the nearest hit.
  bool has_surface_emitters() const { return has_surface_emitters_; }
  /// Media of shapes and sensors, each once, in the order of their first use.
  const std::vector<const Medium*>& media() const { return media_; }
  const std::vector<std::shared_ptr<Sensor>>& sensors() const { return contents_.sensors; }
  Integrator& integrator() const { return *contents_.integrator; }
  const std::string& file() const { return contents_.file; }
  const std::string& hash() const { return contents_.hash; }
  /// Bounding box of all shapes; empty without shapes.
  const Aabb& bounds() const { return bounds_; }

  /// True if both scenes use the same acceleration structure.
  bool shares_structure_with(const Scene& other) const {
    return accelerator_ == other.accelerator_;
  }

  /// Finds the nearest hit of each ray. Adds the time inside Embree to `counters`; the caller
  /// counts rays.
  void intersect(std::span<RayHit> rays, Coherence coherence, RenderCounters& counters) const;
  /// Tests each ray for any hit, and sets its tmax to -infinity if there is one. Batches of about
  /// 1000 rays are fastest.
  void occluded(std::span<Ray> rays, Coherence coherence, RenderCounters& counters) const;

  /// Versions for blocks of 16 rays in Embree's layout. `count` is the number of blocks; lanes may
  /// be inactive. Hits must be cleared (shape = kNoHit) before.
  void intersect(RayHit16* rays, size_t count, Coherence coherence, RenderCounters& counters) const;
  void occluded(Ray16* rays, size_t count, Coherence coherence, RenderCounters& counters) const;

  /// Returns the surface interaction of a valid hit.
  SurfaceInteraction interaction(const RayHit& hit) const {
    const Shape& shape = *contents_.shapes[hit.hit.shape];
    SurfaceInteraction si = shape.interaction(hit.ray, hit.hit);
    si.shape = &shape;
    return si;
  }

 private:
  struct Accelerator;
  /// Instance of a shape group. Embree reports the index of the hit shape in its group, which is
  /// added to `first`.
  struct Placed {
    std::shared_ptr<const ShapeInstance> instance;
    uint32_t first;  ///< index into shapes() of the instance's first part
  };
  void replace_by_parts();
  void check_bounces() const;
  void list_media();
  Contents contents_;
  std::vector<Placed> placed_;
  std::vector<const Emitter*> emitters_;
  std::vector<const Emitter*> indirect_emitters_;
  std::vector<const Medium*> media_;
  const Emitter* environment_ = nullptr;
  bool has_surface_emitters_ = false;
  Aabb bounds_;
  std::shared_ptr<const Accelerator> accelerator_;
};

}  // namespace kinome
