// Shows shading normals: the colour (n + 1) / 2 at hits, black elsewhere.
//
//     <integrator type="normals"/>

#include <kinome/integrator.h>
#include <kinome/plugin.h>
#include <kinome/primary_rays.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"scale", ParameterType::kFloat, "1", "Factor of the colour."},
};

class Normals final : public Integrator {
 public:
  explicit Normals(const Properties& props) : scale_(props.real("scale")) {}

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    const Sampler& sampler = sensor.sampler();
    context.scheduler.for_each_tile(sensor.film(), [&](Tile& tile) {
      PrimaryBatch batch;
      for_each_part(tile.pixels, sampler.sample_count(), 4096, [&](uint32_t first, uint32_t count) {
        batch.trace(scene, sensor, tile.pixels, first, count, key_seed(context.job, sampler),
                    tile.counters);
        for (size_t i = 0; i < batch.size(); ++i) add(tile, sensor.film(), batch, i);
      });
    });
  }

 private:
  void add(Tile& tile, const Film& film, const PrimaryBatch& batch, size_t i) const {
    Rgb color(0.f);
    if (batch.hit(i)) color = 0.5f * scale_ * (batch.interaction(i).frame.n + 1.f);
    const float values[] = {color.x, color.y, color.z, batch.hit(i) ? 1.f : 0.f};
    tile.film.add(batch.film_position(i), {values, film.has_alpha() ? 4u : 3u});
  }

  float scale_;
};

}  // namespace

KINOME_PLUGIN(Normals, Category::kIntegrator, "normals", "Shows shading normals as colours.",
              kParameters);
