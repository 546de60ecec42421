#include "clustered/product/choice/candidates.h"

namespace kinome {

void split_control(const GroupView& group, const Candidates& candidates, size_t first,
                   const Rgb& control, const UnitSums& sums) {
  Rgb rest = control;
  for (size_t i = first; i < candidates.size(); ++i) {
    const Rgb term = group.visibility.v[candidates.cell[i]] * candidates.weight_of(i);
    sums.of(group.primary(candidates.member[i])) += term;
    rest -= term;
  }
  rest /= static_cast<float>(group.group.count);
  for (uint32_t j = 0; j < group.group.count; ++j) sums.of(group.primary(j)) += rest;
}

}  // namespace kinome
