// Text of values in scene files.

#include "editor/saving/written_values.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

namespace kinome::loader {

// A number is read as a double first, so that the text of a float must round to the same float.
std::string written_number(double value) {
  const auto single = static_cast<float>(value);
  const std::string text = fmt::format("{}", single);
  const double read = std::strtod(text.c_str(), nullptr);
  const bool is_single = static_cast<double>(single) == value;
  return is_single && static_cast<float>(read) == single ? text : fmt::format("{}", value);
}

std::string written_triple(const Vec3& v) {
  return written_number(v.x) + ", " + written_number(v.y) + ", " + written_number(v.z);
}

namespace {

std::string written(const Mat4& m) {
  std::string text = written_number(m[0][0]);
  for (int i = 1; i < 16; ++i) {
    text += ' ';
    text += written_number(m[i % 4][i / 4]);
  }
  return text;
}

bool is_colour(const Parameter* row) {
  return row && quantity_of(row->type) != Quantity::kNone;
}

struct ValueElement {
  const std::string& name;
  const Parameter* row;

  std::string plain(const char* tag, const std::string& value) const {
    return fmt::format(R"(<{} name="{}" value="{}"/>)", tag, escaped(name), escaped(value));
  }
  std::string operator()(bool value) const { return plain("boolean", value ? "true" : "false"); }
  std::string operator()(int64_t value) const {
    const bool is_real = is_colour(row) || (row && row->type == ParameterType::kFloat);
    return plain(is_real ? "float" : "integer", std::to_string(value));
  }
  std::string operator()(double value) const { return plain("float", written_number(value)); }
  std::string operator()(const std::string& value) const { return plain("string", value); }
  std::string operator()(const Vec3& value) const {
    // Mitsuba accepts <point> for directions, too.
    return plain(is_colour(row) ? "rgb" : "point", written_triple(value));
  }
  std::string operator()(const UniformColor& value) const {
    const Rgb& c = value.value;
    const bool is_grey = c.x == c.y && c.y == c.z;
    if (is_grey && value.is_float) return plain("float", written_number(c.x));
    if (is_grey && value.spectral) return plain("spectrum", written_number(c.x));
    return plain("rgb", written_triple(c));
  }
  std::string operator()(const Transform& value) const {
    return fmt::format(R"(<transform name="{}"><matrix value="{}"/></transform>)", escaped(name),
                       written(value.matrix()));
  }
  std::string operator()(const std::shared_ptr<const Image>&) const { return ""; }
  std::string operator()(const std::shared_ptr<Object>&) const { return ""; }
};

}  // namespace

std::string escaped(const std::string& text) {
  constexpr std::pair<char, const char*> kReferences[] = {
      {'&', "&amp;"},   {'<', "&lt;"},   {'>', "&gt;"},  {'"', "&quot;"},
      {'\'', "&apos;"}, {'\n', "&#10;"}, {'\t', "&#9;"}, {'\r', "&#13;"}};
  std::string result;
  for (const char c : text) {
    const auto* const found =
        std::ranges::find(kReferences, c, &std::pair<char, const char*>::first);
    result += found == std::end(kReferences) ? std::string(1, c) : found->second;
  }
  return result;
}

void expect_no_name(const std::string& text, const Location& where) {
  if (text.find('$') == std::string::npos) return;
  throw Error(where, "can't write '" + text + "' to a scene file, where a $ begins a name");
}

std::string attribute_text(const std::string& text, const Location& where) {
  expect_no_name(text, where);
  return escaped(text);
}

std::string value_element(const std::string& name, const Properties::Value& value,
                          const Parameter* row) {
  return std::visit(ValueElement{name, row}, value);
}

}  // namespace kinome::loader
