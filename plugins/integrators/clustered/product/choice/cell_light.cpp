#include "clustered/product/choice/cell_light.h"

#include <algorithm>
#include <utility>

namespace kinome {
namespace {

constexpr double kRaysPerPoint = 128, kMinPoints = 1 << 13, kMaxPoints = 1 << 15;

}  // namespace

uint32_t CellLight::points_for(double rays) {
  return static_cast<uint32_t>(std::clamp(rays / kRaysPerPoint, kMinPoints, kMaxPoints));
}

CellLight::CellLight(const DistantCells& distant, const Emitter* sky, CellPoints distant_points,
                     const LocalLight* local_light, LocalPoints points_of_local)
    : cells(distant),
      environment(sky),
      points(std::move(distant_points)),
      local(local_light),
      local_points(std::move(points_of_local)) {
  columns.count = cells.padded_size();
  for (int k = 0; k < 8; ++k) columns.edges[k] = cells.edges()[k].data();
  for (int k = 0; k < 3; ++k) {
    columns.axis[k] = cells.axis()[k].data();
    columns.importance_flux[k] = cells.importance_flux()[k].data();
  }
  for (int k = 0; k < 9; ++k) columns.vector_flux[k] = points.vector_flux[k].data();
  columns.radius = cells.radius().data();
  columns.flux = cells.flux().data();
}

void CellLight::divide_by(const LightGroups& by) {
  groups = &by;
  sky_group = environment ? by.group_of(*environment) : 0;
}

}  // namespace kinome
