#include "kinome/value_source.h"

#include "kinome/error.h"

namespace kinome {

ValueSource::~ValueSource() = default;

std::string describe_min(const Volume& volume) {
  const auto* const source = dynamic_cast<const ValueSource*>(&volume);
  return source ? source->describe_min() : format_number(volume.min());
}

std::string describe_max(const Volume& volume) {
  const auto* const source = dynamic_cast<const ValueSource*>(&volume);
  return source ? source->describe_max() : format_number(volume.max());
}

}  // namespace kinome
