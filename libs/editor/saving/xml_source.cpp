#include "editor/saving/xml_source.h"

#include <algorithm>

#include "scene_xml/nodes/source_locations.h"
#include "scene_xml/nodes/unclosed.h"

namespace kinome::loader {
namespace {

constexpr const char* kBlanks = " \t\r\n";

class SourceScanner {
 public:
  SourceScanner(const std::string& text, const std::string& file)
      : text_(text), locations_(text, file) {}

  SourceElement root() {
    skip_to_element();
    return element();
  }

 private:
  void skip_to_element() {
    at_ = next_tag(text_, at_);
    if (at_ == std::string::npos) throw Error("a scene's text ends within an element");
  }

  SourceElement element() {
    SourceElement found;
    found.begin = at_;
    found.where = locations_.at(at_);
    const size_t name_end = text_.find_first_of(" \t\r\n/>", at_ + 1);
    found.tag = text_.substr(at_ + 1, name_end - at_ - 1);
    at_ = name_end;
    while ((at_ = text_.find_first_not_of(kBlanks, at_)) != std::string::npos &&
           text_[at_] != '>' && text_[at_] != '/') {
      found.attributes.push_back(attribute());
    }
    found.is_one_tag = at_ != std::string::npos && text_[at_] == '/';
    at_ = text_.find('>', at_) + 1;
    found.content_begin = found.content_end = found.end = at_;
    if (found.is_one_tag) return found;
    for (skip_to_element(); text_[at_ + 1] != '/'; skip_to_element()) {
      found.children.push_back(element());
    }
    found.content_end = at_;
    at_ = text_.find('>', at_) + 1;
    found.end = at_;
    return found;
  }

  SourceElement::Attribute attribute() {
    SourceElement::Attribute found;
    found.begin = at_;
    found.where = locations_.at(at_);
    found.name = text_.substr(at_, text_.find_first_of(" \t\r\n=", at_) - at_);
    const size_t quote = text_.find_first_of("\"'", at_);
    found.value_begin = quote + 1;
    found.value_end = text_.find(text_[quote], quote + 1);
    at_ = found.value_end + 1;
    return found;
  }

  const std::string& text_;
  SourceLocations locations_;
  size_t at_ = 0;
};

}  // namespace

const SourceElement::Attribute* SourceElement::find(std::string_view name) const {
  for (const Attribute& attribute : attributes) {
    if (attribute.name == name) return &attribute;
  }
  return nullptr;
}

SourceElement scan_source(const std::string& text, const std::string& file) {
  return SourceScanner(text, file).root();
}

std::string patched(const std::string& text, size_t begin, size_t end,
                    std::vector<TextPatch> patches) {
  std::stable_sort(patches.begin(), patches.end(), [](const TextPatch& a, const TextPatch& b) {
    return std::pair(a.begin, a.end) < std::pair(b.begin, b.end);
  });
  std::string result;
  for (const TextPatch& patch : patches) {
    result.append(text, begin, patch.begin - begin);
    result += patch.text;
    begin = patch.end;
  }
  return result.append(text, begin, end - begin);
}

bool begins_line(const std::string& text, size_t offset) {
  const size_t last = offset == 0 ? std::string::npos : text.find_last_not_of(" \t", offset - 1);
  return last == std::string::npos || text[last] == '\n';
}

std::string indentation_at(const std::string& text, size_t offset) {
  const size_t line = offset == 0 ? std::string::npos : text.rfind('\n', offset - 1);
  const size_t begin = line == std::string::npos ? 0 : line + 1;
  return begins_line(text, offset) ? text.substr(begin, offset - begin) : "";
}

}  // namespace kinome::loader
