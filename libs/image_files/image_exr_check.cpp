#include "image_files/image_exr_check.h"

#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfHeader.h>
#include <ImfPartType.h>
#include <ImfStdIO.h>
#include <ImfTileDescription.h>
#include <ImfVersion.h>
#include <ImfXdr.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <stdexcept>

#include "image_files/image_size.h"

namespace kinome {
namespace {

/// Returns true if the file starts with OpenEXR's magic number. OpenEXR's own test reads more of
/// the file, so it doesn't recognize truncated ones.
bool has_magic(const std::string& path) {
  char bytes[4] = {};
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(std::strerror(errno));
  file.read(bytes, sizeof bytes);
  return Imf::isImfMagic(bytes);
}

/// Returns the number of rows that OpenEXR compresses together.
uint64_t rows_of_block(Imf::Compression compression) {
  switch (compression) {
    case Imf::NO_COMPRESSION:
    case Imf::RLE_COMPRESSION:
    case Imf::ZIPS_COMPRESSION:
      return 1;
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
      return 16;
    case Imf::PIZ_COMPRESSION:
    case Imf::B44_COMPRESSION:
    case Imf::B44A_COMPRESSION:
    case Imf::DWAA_COMPRESSION:
      return 32;
    default:
      return 256;  // DWAB, and future compressions
  }
}

/// Returns the size of an attribute of this type in bytes, or -1 if it varies.
int fixed_size(const std::string& type) {
  static const std::map<std::string, int> kSizes = {
      {"box2f", 16},      {"box2i", 16},   {"chromaticities", 32},
      {"compression", 1}, {"double", 8},   {"envmap", 1},
      {"float", 4},       {"int", 4},      {"keycode", 28},
      {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
      {"m44f", 64},       {"m44d", 128},   {"rational", 8},
      {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
      {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
      {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1}};
  const auto found = kSizes.find(type);
  return found == kSizes.end() ? -1 : found->second;
}

/// Returns true if the bytes of a channel list are consistent: names, each followed by 16 bytes,
/// and an empty name at the end.
bool is_channel_list(const std::string& bytes) {
  size_t at = 0;
  while (at < bytes.size() && bytes[at] != 0) {
    const size_t end = bytes.find('\0', at);
    if (end == std::string::npos) return false;
    at = end + 17;
  }
  return at + 1 == bytes.size();
}

bool is_preview(const std::string& bytes) {
  uint32_t sides[2] = {};
  if (bytes.size() < sizeof sides) return false;
  std::memcpy(sides, bytes.data(), sizeof sides);
  return uint64_t{sides[0]} * sides[1] == (bytes.size() - sizeof sides) / 4;
}

/// Checks the attributes of all headers, because OpenEXR allocates the memory that they claim to
/// need, and trusts their contents rather than their sizes. Throws std::runtime_error if contents
/// and sizes don't agree, an attribute extends beyond the file, or a header has no end.
void check_attributes(const std::string& path, uint64_t file_size, bool is_multipart) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(std::strerror(errno));
  file.seekg(8);  // the magic number and the version
  std::string name, type;
  // An empty name ends a header. In a multi-part file, an empty header ends the list of headers.
  bool is_first = true;
  while (std::getline(file, name, '\0') && !(name.empty() && (is_first || !is_multipart))) {
    is_first = name.empty();
    if (is_first) continue;
    int32_t size = 0;
    std::getline(file, type, '\0');
    file.read(reinterpret_cast<char*>(&size), sizeof size);
    const uint64_t begin = file ? static_cast<uint64_t>(file.tellg()) : file_size;
    if (!file || size < 0 || static_cast<uint64_t>(size) > file_size - begin) {
      throw std::runtime_error("truncated: an attribute of its header extends beyond the file");
    }
    // OpenEXR allocates the memory that an ID manifest claims to need.
    if (type == "idmanifest") throw std::runtime_error("ID manifests are unsupported");
    std::string bytes(static_cast<size_t>(size), '\0');
    file.read(bytes.data(), size);
    const int expected = fixed_size(type);
    if ((expected >= 0 && size != expected) || (type == "chlist" && !is_channel_list(bytes)) ||
        (type == "preview" && !is_preview(bytes))) {
      throw std::runtime_error("damaged: its header has an invalid attribute");
    }
  }
  if (!file) throw std::runtime_error("truncated: its header has no end");
}

/// Returns an upper bound on the number of values that a byte of a compressed file can encode. DWA
/// stores one half for 8x8 equal values, and deflates these. The best of the other compressions is
/// deflate, with at most 1032 : 1.
uint64_t max_values_per_byte(Imf::Compression compression) {
  const bool is_dwa = compression == Imf::DWAA_COMPRESSION || compression == Imf::DWAB_COMPRESSION;
  return is_dwa ? 40000 : 600;
}

/// Throws std::runtime_error if the header describes more pixels than the file can contain, or
/// claims more memory than it can need. Called before any allocation.
void check_header(const Imf::Header& header, bool is_tiled, uint64_t file_size) {
  const Imath::Box2i& window = header.dataWindow();
  const int64_t width = int64_t{window.max.x} - window.min.x + 1;
  const int64_t height = int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw std::runtime_error(
        fmt::format("the size in its header is invalid or too large: {} x {}", width, height));
  }
  uint64_t channels = 0;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    ++channels;
    // Chroma usually has half the resolution of luminance along both axes.
    const std::string name = it.name();
    const int x = it.channel().xSampling, y = it.channel().ySampling;
    const bool is_chroma = (name == "RY" || name == "BY") && x == 2 && y == 2;
    if (!is_chroma && (x != 1 || y != 1)) {
      throw std::runtime_error(
          fmt::format("channel '{}' is subsampled, expected one value per pixel", name));
    }
  }
  if (channels == 0) throw std::runtime_error("it has no channels");
  const uint64_t values_per_byte = max_values_per_byte(header.compression());
  if (static_cast<uint64_t>(width * height) * channels / values_per_byte > file_size) {
    throw std::runtime_error(
        fmt::format("truncated: {} bytes can't hold {} x {} pixels", file_size, width, height));
  }
  // OpenEXR holds a few blocks and a row of tiles in memory, which may be larger than the image.
  uint64_t block_width = static_cast<uint64_t>(width);
  uint64_t block_height = rows_of_block(header.compression());
  if (is_tiled) {
    const Imf::TileDescription& tile = header.tileDescription();
    if (tile.xSize > kMaxSide || tile.ySize > kMaxSide) {
      throw std::runtime_error(
          fmt::format("the tile size in its header is too large: {} x {}", tile.xSize, tile.ySize));
    }
    block_width = std::max<uint64_t>(block_width, tile.xSize);
    block_height = tile.ySize;
  }
  constexpr uint64_t kMaxValues = uint64_t{1} << 26;
  const uint64_t values = block_width * block_height * channels;
  if (values > kMaxValues && values / values_per_byte > file_size) {
    throw std::runtime_error(
        fmt::format("its header claims blocks of {} x {} pixels, which would need {} MB",
                    block_width, block_height, values * sizeof(float) >> 20));
  }
}

/// Checks the headers of all parts, because OpenEXR reads all of them.
void check_headers(const std::string& path, uint64_t file_size) {
  Imf::StdIFStream stream(path.c_str());
  int magic = 0, version = 0;
  Imf::Xdr::read<Imf::StreamIO>(stream, magic);
  Imf::Xdr::read<Imf::StreamIO>(stream, version);
  const bool is_multipart = Imf::isMultiPart(version);
  check_attributes(path, file_size, is_multipart);
  for (bool is_last = false; !is_last;) {
    Imf::Header header;
    header.readFrom(stream, version);
    const std::string type = header.hasType() ? header.type() : "";
    if (Imf::isNonImage(version) || Imf::isDeepData(type)) {
      throw std::runtime_error("it contains deep data, which is unsupported");
    }
    // In a single-part file, only the version counts: it may have tile attributes without tiles.
    const bool is_tiled = is_multipart ? type == Imf::TILEDIMAGE : Imf::isTiled(version);
    if (is_tiled && !header.hasTileDescription()) {
      throw std::runtime_error("damaged: the tile size is missing in its header");
    }
    check_header(header, is_tiled, file_size);
    is_last = true;
    if (is_multipart) {
      char next = 0;
      const uint64_t at = stream.tellg();
      is_last = (stream.read(&next, 1), next == 0);
      stream.seekg(at);
    }
  }
}

}  // namespace

void check_exr(const std::string& path) {
  if (!has_magic(path)) throw std::runtime_error("it is not an OpenEXR file");
  // These limits keep OpenEXR's tables small.
  static std::once_flag is_limited;
  std::call_once(is_limited, [] {
    Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
    Imf::Header::setMaxTileSize(kMaxSide, kMaxSide);
  });
  check_headers(path, std::filesystem::file_size(path));
}

}  // namespace kinome
