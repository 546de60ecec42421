#pragma once

#include <gtest/gtest.h>

#include <numeric>

#include "kinome/image_files.h"
#include "product_scenes.h"

/// Cases of `clustered` with product sampling, which are compared with `direct`.
namespace kinome::test::product_cases {

struct Case {
  const char* name;
  Arrangement setup;
};
inline Case with(const char* name, const std::function<void(Arrangement&)>& change) {
  Case c{name, {}};
  change(c.setup);
  return c;
}
inline Case of_material(const char* name, const std::string& material, int times = 1) {
  return with(name, [&](Arrangement& s) {
    s.shapes = shapes_xml(material);
    s = often(s, times);
  });
}

}  // namespace kinome::test::product_cases
