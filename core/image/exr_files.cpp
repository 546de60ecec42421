#include "image/exr_files.h"

#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>

#include "base/file_writer.h"

namespace kinome {
namespace {

constexpr const char* kNoMemory = "it needs more memory than there is";

/// Lets OpenEXR write through a FileWriter. Also tells whether parts of the picture are missing:
/// where memory ends in one of OpenEXR's own threads, it writes what it has, and says nothing.
class WriterStream : public Imf::OStream {
 public:
  WriterStream(FileWriter& writer, const std::string& path)
      : Imf::OStream(path.c_str()), writer_(writer) {}
  void write(const char bytes[], int count) override {
    constexpr int kOffset = 8;  // bytes, and 0 where there is no such part
    has_holes_ |= is_in_table_ && count == kOffset &&
                  std::all_of(bytes, bytes + count, [](char byte) { return byte == 0; });
    writer_.write(bytes, static_cast<size_t>(count));
  }
  uint64_t tellp() override { return writer_.position(); }
  /// Only to write the table of the parts' offsets, at the end.
  void seekp(uint64_t position) override {
    is_in_table_ = true;
    writer_.seek(position);
  }
  bool has_holes() const { return has_holes_; }

 private:
  bool is_in_table_ = false, has_holes_ = false;
  FileWriter& writer_;
};

}  // namespace

void write_by_openexr(const std::string& path, const std::function<void(Imf::OStream&)>& write) {
  FileWriter writer(path);
  std::string why;
  WriterStream stream(writer, path);
  try {
    write(stream);
  } catch (const std::bad_alloc&) {
    why = kNoMemory;
  } catch (const std::exception& e) {
    why = e.what();
  }
  if (why.empty() && stream.has_holes()) why = kNoMemory;
  // A failed write comes first: what OpenEXR says is a consequence of it.
  if (!why.empty() && !writer.failed()) {
    throw Error(fmt::format("cannot write '{}': {}", path, why));
  }
  writer.commit();
}

std::string why_unreadable(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error)) return kNoMemory;
  std::string why = error.what();
  // OpenEXR puts the path in front, and the end of a file is one of several texts of its own.
  for (const char* text : {"end of file", "Early end", "missing", "corrupt"}) {
    if (why.find(text) != std::string::npos && why.find("truncated") == std::string::npos) {
      why = "truncated or damaged OpenEXR file (" + why + ")";
    }
  }
  return why;
}

void read_metadata(const Imf::Header& header, ImageMetadata& metadata) {
  for (auto it = header.begin(); it != header.end(); ++it) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute())) {
      metadata[it.name()] = text->value();
    }
  }
}

}  // namespace kinome
