#pragma once

#include <string>
#include <utility>
#include <vector>

#include "check/random.h"
#include "check/rays.h"
#include "support/render.h"

namespace kinome::test {

using namespace check;

/// Message of the Error that `action` throws; "" where it throws none.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace kinome::test
