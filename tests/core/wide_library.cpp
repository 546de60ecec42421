// The checks of wide numbers as a library, which is built for each instruction set.

#include "wide_checks.h"

namespace kinome::test {
namespace {

const std::vector<WideCheck>& all_checks() {
  static const std::vector<WideCheck> all = [] {
    std::vector<WideCheck> list;
    for (const auto& group :
         {number_checks(), integer_checks(), vector_checks(), function_checks(),
          double_checks()}) {
      list.insert(list.end(), group.begin(), group.end());
    }
    return list;
  }();
  return all;
}

}  // namespace
}  // namespace kinome::test

extern "C" __attribute__((visibility("default"))) kinome::test::WideLibrary kinome_wide_library() {
  const auto& all = kinome::test::all_checks();
  return {KINOME_ABI_ISA, kinome::wide::kLanes, all.data(), all.size()};
}
