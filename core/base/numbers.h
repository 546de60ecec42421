#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

/// Numbers as scene files write them: independent of the locale, and strict. What isn't a number
/// as a whole ("1.5x"), isn't finite, or doesn't fit a float is none at all.
namespace kinome {

std::string_view trim(std::string_view text);
std::optional<double> parse_real(std::string_view text);
std::optional<int64_t> parse_integer(std::string_view text);
/// "true" or "false", in any case.
std::optional<bool> parse_boolean(std::string_view text);
/// The parts between spaces and commas.
std::vector<std::string_view> split_list(std::string_view text);
/// Numbers separated by spaces or commas.
std::optional<std::vector<double>> parse_reals(std::string_view text);

}  // namespace kinome
