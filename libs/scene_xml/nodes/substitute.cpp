#include "scene_xml/nodes/substitute.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kinome::loader {
namespace {

/// Limits in bytes for one attribute and for all substitutions, against exponential growth.
constexpr size_t kMaxAttributeSize = 1 << 20;
constexpr size_t kMaxSubstitutedBytes = 64 << 20;

}  // namespace

Substitution::Substitution(const std::map<std::string, std::string>& defines, Faults& faults)
    : values_(defines), faults_(faults) {
  for (const auto& [name, value] : defines) defines_.insert(name);
}

void Substitution::add_default(const std::string& name, const std::string& value) {
  values_.emplace(name, value);
}

void Substitution::lose(const std::string& name) {
  if (name.empty()) {
    has_lost_any_ = true;
  } else if (!values_.count(name)) {
    lost_.insert(name);
  }
}

std::optional<std::string> Substitution::apply(const Attribute& attribute) {
  std::string result;
  bool is_whole = true;
  std::string_view rest = attribute.value;
  for (size_t dollar; (dollar = rest.find('$')) != std::string_view::npos;) {
    result += rest.substr(0, dollar);
    rest.remove_prefix(dollar + 1);
    const auto* const match = longest_match(rest);
    const size_t lost = longest_lost(rest);
    if (!match || lost > match->first.size()) {
      is_whole = false;
      rest.remove_prefix(lost > 0 ? lost : report_undefined(rest, attribute.where));
      continue;
    }
    const auto& [name, value] = *match;
    result += value;
    rest.remove_prefix(name.size());
    used_.insert(name);
    if (result.size() > kMaxAttributeSize) {
      faults_.add(attribute.where, "the value grows too long by substitution");
      return std::nullopt;
    }
    total_ += value.size();
    if (total_ > kMaxSubstitutedBytes) {
      faults_.stop(Error(attribute.where, "the scene grows too large by substitution"));
    }
  }
  if (!is_whole) return std::nullopt;
  return result += rest;
}

void Substitution::check_all_used(const std::string& file) const {
  if (has_lost_any_) return;
  for (const std::string& name : defines_) {
    // A suggested name is already part of the error of a misspelt one.
    if (used_.count(name) || suggested_.count(name)) continue;
    faults_.add(Location{file, 0, 0}, "the scene doesn't use -D " + name + hint_of(name));
  }
}

const std::pair<const std::string, std::string>* Substitution::longest_match(
    std::string_view text) const {
  const std::pair<const std::string, std::string>* best = nullptr;
  for (const auto& entry : values_) {
    if (text.starts_with(entry.first) && (!best || entry.first.size() > best->first.size())) {
      best = &entry;
    }
  }
  return best;
}

/// Returns the length of the longest name at the beginning of `text` that is undefined by an error;
/// 0 if there is none.
size_t Substitution::longest_lost(std::string_view text) const {
  size_t longest = 0;
  for (const std::string& name : lost_) {
    if (text.starts_with(name)) longest = std::max(longest, name.size());
  }
  return longest;
}

/// Reports the undefined name at the beginning of `text`, and returns its length.
size_t Substitution::report_undefined(std::string_view text, const Location& where) {
  const auto is_name = [](char c) {
    return c == '_' || std::isalnum(static_cast<unsigned char>(c));
  };
  const std::string name(text.begin(), std::find_if_not(text.begin(), text.end(), is_name));
  if (has_lost_any_) return name.size();
  std::vector<std::string> known;
  for (const auto& entry : values_) known.push_back(entry.first);
  const std::string nearest = faults_.nearest(name, known);
  suggested_.insert(nearest);
  faults_.add(where, "undefined parameter '$" + name + "'" + did_you_mean(nearest, "$"));
  return name.size();
}

/// Returns a hint at the names that the scene uses.
std::string Substitution::hint_of(const std::string& name) const {
  constexpr size_t kMaxNamed = 12;
  const std::string nearest = nearest_name(name, used_);
  if (!nearest.empty()) return did_you_mean(nearest);
  if (used_.empty()) return " (it uses none)";
  std::vector<std::string> some(used_.begin(), used_.end());
  const bool has_more = some.size() > kMaxNamed;
  if (has_more) some.resize(kMaxNamed);
  return fmt::format(" (it uses {}{})", fmt::join(some, ", "), has_more ? ", …" : "");
}

}  // namespace kinome::loader
