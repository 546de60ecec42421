#include "image_files/exr_files.h"

#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <system_error>
#include <thread>

#include "kinome/image_files.h"
#include "output_files/file_writer.h"

namespace kinome {
namespace {

constexpr const char* kNoMemory = "out of memory";

std::atomic<unsigned> image_file_threads{0};

/// Stream through which OpenEXR writes to a FileWriter. Also detects missing blocks: if one of
/// OpenEXR's threads runs out of memory, OpenEXR writes an incomplete file and reports no error.
class WriterStream : public Imf::OStream {
 public:
  WriterStream(FileWriter& writer, const std::string& path)
      : Imf::OStream(path.c_str()), writer_(writer) {}
  void write(const char bytes[], int count) override {
    constexpr int kOffsetBytes = 8;  // an offset of 0 means that the block is missing
    has_holes_ |= is_in_table_ && count == kOffsetBytes &&
                  std::all_of(bytes, bytes + count, [](char byte) { return byte == 0; });
    writer_.write(bytes, static_cast<size_t>(count));
  }
  uint64_t tellp() override { return writer_.position(); }
  /// OpenEXR calls this only to write the table of offsets at the end.
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

void set_image_file_threads(unsigned threads) {
  image_file_threads = threads;
}

void use_threads_for(uint64_t bytes) {
  constexpr uint64_t kMinBytes = 1 << 20;  // fewer take less time than threads to start
  if (bytes < kMinBytes) return;
  const unsigned wanted = image_file_threads;
  const unsigned threads = wanted > 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
  // With one thread, OpenEXR works in the caller's.
  const int count = threads > 1 ? static_cast<int>(threads) : 0;
  static std::mutex mutex;  // OpenEXR's function is not thread-safe
  const std::lock_guard lock(mutex);
  try {
    if (Imf::globalThreadCount() != count) Imf::setGlobalThreadCount(count);
  } catch (const std::system_error&) {
    // Without further threads, the file takes longer.
  }
}

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
  // If a write has failed, report that error: OpenEXR's exception is a consequence of it.
  if (!why.empty() && !writer.failed()) {
    throw Error(fmt::format("cannot write '{}': {}", path, why));
  }
  writer.commit();
}

std::string why_unreadable(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error)) return kNoMemory;
  std::string why = error.what();
  // OpenEXR uses several messages for a truncated file.
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
