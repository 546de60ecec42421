#pragma once

#include <string>

#include "kinome/volume.h"

namespace kinome {

/// Optional interface of volumes that consist of many values, for error messages: derive them from
/// this class in addition to Volume.
class KINOME_EXPORT ValueSource {
 public:
  virtual ~ValueSource();
  /// Describes the smallest and the largest value: "-1 in voxel (3, 2, 1) of smoke.vol".
  virtual std::string describe_min() const = 0;
  virtual std::string describe_max() const = 0;
};

/// Describes the smallest and the largest value of a volume: its ValueSource's description, or the
/// number.
KINOME_EXPORT std::string describe_min(const Volume& volume);
KINOME_EXPORT std::string describe_max(const Volume& volume);

}  // namespace kinome
