#include "kinome/integrator.h"

#include "kinome/error.h"

namespace kinome {

std::vector<Inspection> Integrator::inspect(const Scene& /*scene*/, const Sensor& /*sensor*/,
                                            RenderContext& /*context*/,
                                            const Vec2& /*film_position*/) const {
  throw Error("the scene's integrator has no clusters to inspect: 'clustered' has");
}

}  // namespace kinome
