// An integrator with a fault, for tests of the program's reaction.

#include <array>

#include "faulty.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_FAULT_PARAMETER};

/// Grey pixels, except for its fault.
class FaultyIntegrator final : public Integrator {
 public:
  explicit FaultyIntegrator(const Properties& props) : fault_(props) {}

  void render(const Scene& /*scene*/, const Sensor& sensor, RenderContext& context) const override {
    fault_.throw_if("render", "render");
    fault_.crash_if("in render");
    if (fault_.is("crash in the core")) {
      Film* const volatile none = nullptr;
      context.scheduler.commit(*none, 0, {sensor.film().make_tile({0, 0, 1, 1})});
    }
    if (fault_.is("preparing")) {
      context.scheduler.parallel_for(1000,
                                     [&](size_t) { fault_.throw_if("preparing", "prepare"); });
    }
    context.scheduler.for_each_tile(sensor.film(), [&](Tile& tile) {
      fault_.throw_if("worker", "work");
      const Rect& pixels = tile.pixels;
      for (int y = pixels.y0; y < pixels.y1; ++y) {
        for (int x = pixels.x0; x < pixels.x1; ++x) {
          const float value = fault_.is("nan") && x == y ? kNan : 0.5f;
          tile.film.add_pixel(x, y, std::array{value, value, value});
        }
      }
    });
  }

 private:
  Fault fault_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::FaultyIntegrator, kinome::Category::kIntegrator, "faulty",
              "Has a fault.", kinome::test::kTable);
