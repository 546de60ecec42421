#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace kinome::app {

/// Prints to stderr what may be lost: a terminal may be gone, for which fmt::print would throw, and
/// what is rendered is to be written all the same.
template <class... T>
void say(fmt::format_string<T...> format, T&&... values) {
  const std::string text = fmt::format(format, std::forward<T>(values)...);
  std::fputs(text.c_str(), stderr);
}

}  // namespace kinome::app
