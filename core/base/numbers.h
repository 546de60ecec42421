#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

/// Parsers for the numbers of scene files, independent of the locale. They return nullopt unless
/// the whole text is a number (not "1.5x"); reals must also be finite and fit a float.
namespace kinome {

std::string_view trim(std::string_view text);
std::optional<double> parse_real(std::string_view text);
std::optional<int64_t> parse_integer(std::string_view text);
/// Parses "true" or "false", in upper or lower case.
std::optional<bool> parse_boolean(std::string_view text);
/// Splits the text at spaces and commas.
std::vector<std::string_view> split_list(std::string_view text);
/// Parses numbers separated by spaces or commas.
std::optional<std::vector<double>> parse_reals(std::string_view text);

}  // namespace kinome
