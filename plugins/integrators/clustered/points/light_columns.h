#pragma once

#include "kinome/light_points.h"
#include "transport/arena.h"

namespace kinome {

/// Light points as columns, in the order of a set of LightPoints, which must outlive it. Immutable;
/// thread-safe.
class LightColumns {
 public:
  explicit LightColumns(const LightPoints& points);

  const LightPoints& points() const { return points_; }
  bool is_local() const { return points_.kind == LightPoints::Kind::kLocal; }
  const Columns3& position() const { return position_; }
  const Columns3& normal() const { return normal_; }  ///< only for local light
  const Columns3& power() const { return power_; }

 private:
  const LightPoints& points_;
  transport::Arena arena_;
  Columns3 position_, normal_, power_;
};

}  // namespace kinome
