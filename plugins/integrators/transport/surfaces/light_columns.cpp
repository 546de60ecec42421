#include "transport/surfaces/light_columns.h"

#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

namespace {

void append(const Columns3& columns, std::vector<float*>& values) {
  for (float* const column : {columns.x, columns.y, columns.z}) values.push_back(column);
}

}  // namespace

void LightColumns::add_color(std::vector<float*>& values) const {
  append(total_, values);
}

void LightColumns::add_groups(std::vector<float*>& values) const {
  if (groups_ == 0) return;
  for_each_group(groups_, radiance_,
                 [&](const Columns3& of_group) { append(of_group, values); });
}

void LightColumns::finish(size_t samples) const {
  if (groups_ == 0) return;
  for_lanes(samples, [&](size_t i) {
    wide::Rgb sum(0.f);
    for_each_group(groups_, radiance_, [&](const Columns3& of_group) {
      const wide::Rgb light = wide::Rgb::load(of_group, i);
      sum += light;
      if (response_ != 1) (light * Float(response_)).store(of_group, i);
    });
    sum.store(total_, i);
  });
}

}  // namespace kinome::transport
