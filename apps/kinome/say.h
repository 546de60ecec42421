#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace kinome::app {

/// Prints to stderr and ignores failures. If the terminal is closed, fmt::print would throw, but
/// the image must be written all the same.
template <class... T>
void say(fmt::format_string<T...> format, T&&... values) {
  const std::string text = fmt::format(format, std::forward<T>(values)...);
  std::fputs(text.c_str(), stderr);
}

}  // namespace kinome::app
