#include "transport/surfaces/shading.h"

namespace kinome::transport {

BsdfAnswer make_answer(Arena& a) {
  return {a.three(), a.floats(), a.three(), a.three(), a.floats(), a.floats()};
}

void shade(const Surfaces& surfaces, const BsdfQuery& query, const BsdfAnswer& answer) {
  shade(surfaces, surfaces.points().wi, query, answer);
}

void shade(const Surfaces& surfaces, const Columns3& wi, const BsdfQuery& query,
           const BsdfAnswer& answer) {
  SurfaceBlock points = surfaces.points();
  points.wi = wi;
  const auto ranges = surfaces.ranges();
  for (size_t k = 0; k < ranges.size() && ranges[k].first < surfaces.reflecting();) {
    const Bsdf& bsdf = *ranges[k].row->bsdf;
    const size_t first = ranges[k].first;
    size_t end = first;
    for (; k < ranges.size() && ranges[k].row->bsdf == &bsdf; ++k) {
      end = ranges[k].first + ranges[k].count;
    }
    BsdfQuery of_bsdf = query.from(first);
    if (first >= surfaces.scattering()) of_bsdf.wo = {};
    if (!of_bsdf.wo.x && !of_bsdf.u1) continue;
    bsdf.shade_block(points.part(first, end - first), of_bsdf, answer.from(first));
  }
}

}  // namespace kinome::transport
