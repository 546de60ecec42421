#include "clustered/points/light_columns.h"

namespace kinome {

LightColumns::LightColumns(const LightPoints& points)
    : points_(points),
      arena_(points.size()),
      position_(arena_.three()),
      normal_(is_local() ? arena_.three() : Columns3{}),
      power_(arena_.three()) {
  for (size_t i = 0; i < points.size(); ++i) {
    position_.set(i, points.position[i]);
    power_.set(i, points.power[i]);
    if (is_local()) normal_.set(i, points.normal[i]);
  }
}

}  // namespace kinome
