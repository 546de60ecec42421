#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kinome/emitter.h"
#include "kinome/integrator.h"
#include "kinome/ray.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/shape_group.h"
#include "kinome/stats.h"

namespace kinome {

enum class Coherence { kIncoherent, kCoherent };

/// Everything that is rendered; immutable once built, and safe to use from all threads.
class KINOME_EXPORT Scene {
 public:
  struct Contents {
    std::vector<std::shared_ptr<Shape>> shapes;
    std::vector<std::shared_ptr<Emitter>> emitters;  ///< those that are not part of a shape
    std::vector<std::shared_ptr<Sensor>> sensors;
    std::shared_ptr<Integrator> integrator;
    std::string file;
    std::string hash;  ///< of the scene file's text with includes and -D, 16 hex digits
    /// Whether no ray slips through between two triangles that share an edge. Without it rays take
    /// some 10 % less time, and of a million about one goes through a finely divided surface.
    bool watertight = true;
  };
  /// Builds the acceleration structure with `threads` threads. Every shape must have its BSDF.
  /// `before`: a scene whose structure is taken over if it is of the very same shapes, none of
  /// which has changed its geometry since.
  Scene(Contents contents, unsigned threads, const Scene* before = nullptr);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// All that rays can hit: in place of a shape that has parts these, in their order.
  const std::vector<std::shared_ptr<Shape>>& shapes() const { return contents_.shapes; }
  /// All emitters that shine by themselves, those of shapes and nested ones included.
  const std::vector<const Emitter*>& emitters() const { return emitters_; }
  /// Emitters that offer the bounce of others (Emitter::is_indirect).
  const std::vector<const Emitter*>& indirect_emitters() const { return indirect_emitters_; }
  /// The environment, or nullptr.
  const Emitter* environment() const { return environment_; }
  /// True where some shape emits: rays that look for light must then find the nearest surface.
  bool has_surface_emitters() const { return has_surface_emitters_; }
  const std::vector<std::shared_ptr<Sensor>>& sensors() const { return contents_.sensors; }
  Integrator& integrator() const { return *contents_.integrator; }
  const std::string& file() const { return contents_.file; }
  const std::string& hash() const { return contents_.hash; }
  /// Of all shapes; empty for a scene without any.
  const Aabb& bounds() const { return bounds_; }

  /// Whether it has the acceleration structure of another one.
  bool shares_structure_with(const Scene& other) const {
    return accelerator_ == other.accelerator_;
  }

  /// Nearest hits of a batch. Adds the time inside Embree to `counters`; ray counts are the
  /// caller's business.
  void intersect(std::span<RayHit> rays, Coherence coherence, RenderCounters& counters) const;
  /// Sets tmax of each ray that meets anything to -infinity. Batches of some 1000 are fastest.
  void occluded(std::span<Ray> rays, Coherence coherence, RenderCounters& counters) const;

  /// The same for blocks of 16 rays, laid out as Embree wants them: `count` blocks, each of whose
  /// lanes may be off. Hits are to be cleared (shape kNoHit) before.
  void intersect(RayHit16* rays, size_t count, Coherence coherence, RenderCounters& counters) const;
  void occluded(Ray16* rays, size_t count, Coherence coherence, RenderCounters& counters) const;

  /// The surface that a valid hit lies on.
  SurfaceInteraction interaction(const RayHit& hit) const {
    const Shape& shape = *contents_.shapes[hit.hit.shape];
    SurfaceInteraction si = shape.interaction(hit.ray, hit.hit);
    si.shape = &shape;
    return si;
  }

 private:
  struct Accelerator;
  /// The ray tracer tells of a hit with an instance which of the group's shapes it is: that many
  /// shapes after the first.
  struct Placed {
    std::shared_ptr<const ShapeInstance> instance;
    uint32_t first;  ///< index into shapes() of its first part
  };
  void replace_by_parts();
  void check_bounces() const;
  Contents contents_;
  std::vector<Placed> placed_;
  std::vector<const Emitter*> emitters_;
  std::vector<const Emitter*> indirect_emitters_;
  const Emitter* environment_ = nullptr;
  bool has_surface_emitters_ = false;
  Aabb bounds_;
  std::shared_ptr<const Accelerator> accelerator_;
};

}  // namespace kinome
