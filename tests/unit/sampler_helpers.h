#pragma once

#include <memory>
#include <string>

#include "kinome/sampler.h"
#include "support/render.h"

namespace kinome::test {

inline std::shared_ptr<Sampler> make_sampler(const std::string& type, int count) {
  return make<Sampler>("<sampler type=\"" + type + "\"><integer name=\"sample_count\" value=\"" +
                       std::to_string(count) + "\"/></sampler>");
}

}  // namespace kinome::test
