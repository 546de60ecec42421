#include "session/part_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>

#include "base/fnv1a.h"
#include "image_files/exr_files.h"
#include "image_files/image_exr_check.h"
#include "kinome/error.h"
#include "kinome/scene_loader.h"
#include "session/scratch_folder.h"

namespace kinome {
namespace {

constexpr const char* kPartAttribute = "kinome:part";
constexpr const char* kFilmAttribute = "kinome:part_film";
constexpr const char* kComponents[] = {"float16", "float32", "uint32"};
constexpr Imf::PixelType kComponentTypes[] = {Imf::HALF, Imf::FLOAT, Imf::UINT};
/// Approximate number of bytes of sums that are read at once.
constexpr size_t kBlockBytes = size_t{1} << 24;
/// Number of rows that OpenEXR's ZIP compresses together.
constexpr int kZipRows = 16;

/// Sums stored contiguously for each pixel: a layer's values, or its splats.
struct SumColumns {
  std::string name;  ///< prefix of the channels' names
  double* data;
  size_t stride;  ///< sums per pixel
};

std::vector<SumColumns> columns_of(const std::vector<FilmSums>& sums, size_t pixels) {
  std::vector<SumColumns> columns;
  for (size_t l = 0; l < sums.size(); ++l) {
    const FilmSums& of = sums[l];
    columns.push_back({fmt::format("{}.", l), of.values.data(), of.values.size() / pixels});
    if (of.splats.empty()) continue;
    columns.push_back({fmt::format("{}.splats.", l), of.splats.data(), of.splats.size() / pixels});
  }
  return columns;
}

/// Calls fn(name, offset of the half within the double in bytes, column, index of the sum within a
/// pixel) for each channel of the EXR part "sums".
template <class Function>
void for_each_half(const std::vector<SumColumns>& columns, const Function& fn) {
  for (const SumColumns& column : columns) {
    for (size_t i = 0; i < column.stride; ++i) {
      // On little-endian machines, the lower half comes first.
      fn(fmt::format("{}{}.low", column.name, i), 0, column, i);
      fn(fmt::format("{}{}.high", column.name, i), sizeof(uint32_t), column, i);
    }
  }
}

/// Returns slices for the halves of `rows` rows whose first pixel is `origin`.
Imf::FrameBuffer half_slices(const std::vector<SumColumns>& columns, const Imath::V2i& origin,
                             int width, int rows) {
  Imf::FrameBuffer buffer;
  for_each_half(columns, [&](const std::string& name, size_t offset, const SumColumns& column,
                             size_t number) {
    const size_t pixel_bytes = column.stride * sizeof(double);
    auto* const first = reinterpret_cast<char*>(column.data + number) + offset;
    buffer.insert(name, Imf::Slice::Make(Imf::UINT, first, origin, width, rows, pixel_bytes,
                                         pixel_bytes * static_cast<size_t>(width)));
  });
  return buffer;
}

/// Hashes the sums row by row, so that the hash doesn't depend on the size of the blocks.
void add_rows(Fnv1a& hash, const std::vector<SumColumns>& columns, int width, int rows) {
  for (int y = 0; y < rows; ++y) {
    for (const SumColumns& column : columns) {
      const size_t row = column.stride * static_cast<size_t>(width);
      hash.add(column.data + static_cast<size_t>(y) * row, row * sizeof(double));
    }
  }
}

/// Parses "3/16": the part's number, from 1, and the number of parts.
ImagePart part_of(const std::string& text) {
  uint32_t number = 0, count = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, number);
  const bool is_half = first.ec == std::errc{} && first.ptr != end && *first.ptr == '/';
  const auto second = std::from_chars(is_half ? first.ptr + 1 : end, end, count);
  if (second.ec != std::errc{} || second.ptr != end || number < 1 || number > count ||
      count > ImagePart::kMaxParts) {
    throw std::runtime_error("damaged: its attribute kinome:part is invalid");
  }
  return {number - 1, count};
}

Error part_error(const std::string& path, const std::string& why) {
  return Error(Location{path}, why);
}

/// Returns the result of `read`, and converts its exceptions to an Error at the file.
template <class Read>
auto reading(const std::string& path, const Read& read) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw part_error(path, std::filesystem::exists(path, ignored)
                               ? "can't be read: it is not a file"
                               : "can't be read: no such file");
  }
  try {
    return read();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw part_error(path, "can't be read: " + why_unreadable(error));
  }
}

PartHeader header_of(const std::string& path) {
  check_exr(path);
  const Imf::MultiPartInputFile file(path.c_str());
  const Imf::Header& image = file.header(0);
  PartHeader header;
  header.path = path;
  read_metadata(image, header.metadata);
  const auto part = header.metadata.extract(kPartAttribute);
  const auto film = header.metadata.extract(kFilmAttribute);
  if (part.empty() || film.empty()) {
    throw part_error(path, "it is an image, but not a part written by kinome --part");
  }
  if (file.parts() != 2 || file.header(1).dataWindow() != image.dataWindow()) {
    throw std::runtime_error("damaged: its sums are missing");
  }
  header.part = part_of(part.mapped());
  header.film = part_film_of(film.mapped());
  for (const char* own : {"name", "type"}) header.metadata.erase(own);  // attributes of EXR parts
  const Imath::Box2i& window = image.dataWindow();
  const Imath::Box2i& whole = image.displayWindow();
  header.crop = {window.min.x, window.min.y, window.max.x + 1, window.max.y + 1};
  header.width = whole.max.x + 1;
  header.height = whole.max.y + 1;
  return header;
}

/// Reads the file's sums in blocks of rows, and calls fn(first row, number of rows, sums) for each.
/// `form` gives the expected names and strides of the columns.
template <class Function>
void read_sums(const PartHeader& header, const std::vector<SumColumns>& form, const Function& fn) {
  check_exr(header.path);
  Imf::MultiPartInputFile file(header.path.c_str());
  Imf::InputPart part(file, 1);
  for_each_half(form, [&](const std::string& name, size_t, const SumColumns&, size_t) {
    const Imf::Channel* const channel = part.header().channels().findChannel(name);
    if (channel && channel->type == Imf::UINT) return;
    throw std::runtime_error("damaged: its sums don't match its attribute kinome:part_film");
  });
  const Rect& crop = header.crop;
  const auto width = static_cast<size_t>(crop.width());
  size_t sums_per_pixel = 0;
  for (const SumColumns& column : form) sums_per_pixel += column.stride;
  const size_t fitting = kBlockBytes / std::max<size_t>(1, sums_per_pixel * width * sizeof(double));
  const int rows =
      std::min(crop.height(), std::max(static_cast<int>(fitting), kZipRows) / kZipRows * kZipRows);
  std::vector<double> block(sums_per_pixel * width * static_cast<size_t>(rows));
  std::vector<SumColumns> columns = form;
  double* next = block.data();
  for (SumColumns& column : columns) {
    column.data = next;
    next += column.stride * width * static_cast<size_t>(rows);
  }
  for (int y = crop.y0; y < crop.y1; y += rows) {
    const int count = std::min(rows, crop.y1 - y);
    part.setFrameBuffer(half_slices(columns, {crop.x0, y}, crop.width(), count));
    part.readPixels(y, y + count - 1);
    fn(y - crop.y0, count, columns);
  }
}

}  // namespace

PartHeader read_part_header(const std::string& path) {
  return reading(path, [&] { return header_of(path); });
}

std::shared_ptr<Film> make_film_of_part(const PartHeader& header, PluginRegistry& registry,
                                        uint32_t lanes) {
  const auto integer = [](const char* name, int value) {
    return fmt::format("<integer name=\"{}\" value=\"{}\"/>", name, value);
  };
  const auto choice = [&](const char* name, const std::string& value) {
    // The value comes from the file and is inserted into XML, so it must not contain XML syntax.
    if (!std::all_of(value.begin(), value.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; })) {
      throw part_error(header.path, "it is damaged: its attribute kinome:part_film is invalid");
    }
    return fmt::format("<string name=\"{}\" value=\"{}\"/>", name, value);
  };
  const Rect& crop = header.crop;
  const std::string xml =
      "<film type=\"hdrfilm\">" + integer("width", header.width) +
      integer("height", header.height) + integer("crop_offset_x", crop.x0) +
      integer("crop_offset_y", crop.y0) + integer("crop_width", crop.width()) +
      integer("crop_height", crop.height()) + choice("pixel_format", header.film.colors) +
      choice("component_format", header.film.component) + "<rfilter type=\"box\"/></film>";
  const auto object = load_object_from_string(xml, header.path, {}, registry);
  const auto film = std::dynamic_pointer_cast<Film>(object);
  if (!film) throw part_error(header.path, "it is damaged: it has no film");
  film->prepare(header.film.layers, header.film.channels, lanes);
  film->set_response(header.film.response);
  return film;
}

void add_part(const PartHeader& header, Film& film) {
  const std::vector<FilmSums> sums = film.layer_sums(header.film.has_splats);
  const auto width = static_cast<size_t>(header.crop.width());
  const auto pixels = width * static_cast<size_t>(header.crop.height());
  // The sums that the file contains.
  std::vector<FilmSums> of_file = sums;
  for (size_t l = 0; l < sums.size(); ++l) {
    if (!header.film.has_splats[l]) of_file[l].splats = {};
  }
  const std::vector<SumColumns> to = columns_of(of_file, pixels);
  Fnv1a hash;
  reading(header.path, [&] {
    read_sums(header, to, [&](int y, int count, const std::vector<SumColumns>& from) {
      add_rows(hash, from, header.crop.width(), count);
      for (size_t c = 0; c < to.size(); ++c) {
        const size_t row = to[c].stride * width;
        double* const sum = to[c].data + static_cast<size_t>(y) * row;
        for (size_t i = 0; i < row * static_cast<size_t>(count); ++i) sum[i] += from[c].data[i];
      }
    });
  });
  if (hash.value() != header.film.hash) {
    throw part_error(header.path, "it is damaged: the checksum of its sums is wrong");
  }
  for (size_t l = 0; l < sums.size(); ++l) *sums[l].light_paths += header.film.light_paths[l];
  film.add_non_finite(header.film.non_finite);
}

void write_part_file(const std::string& path, Film& film, PartFilm of, const ImagePart& part,
                     const Image& image, ImageMetadata metadata) {
  const Rect& crop = film.crop();
  const std::vector<FilmSums> sums = film.layer_sums();
  of.non_finite = film.non_finite();
  for (const FilmSums& layer : sums) {
    of.light_paths.push_back(*layer.light_paths);
    of.has_splats.push_back(!layer.splats.empty());
  }
  const std::vector<SumColumns> columns = columns_of(sums, static_cast<size_t>(crop.area()));
  Fnv1a hash;
  add_rows(hash, columns, crop.width(), crop.height());
  of.hash = hash.value();

  // The film writes the image to a temporary file, which is copied.
  const ScratchFolder scratch(path);
  const std::string image_path = scratch.file("image.exr");
  film.write(image_path, image, metadata);
  Imf::InputFile image_file(image_path.c_str());
  Imf::Header headers[2] = {image_file.header(), image_file.header()};
  const Imf::ChannelList& written = headers[0].channels();
  const auto type = std::find(std::begin(kComponentTypes), std::end(kComponentTypes),
                              written.begin().channel().type);
  of.component = kComponents[type - kComponentTypes];
  of.colors = film.channels()[0] == "Y" ? "luminance" : written.findChannel("R") ? "rgb" : "xyz";
  const bool is_luminance = of.colors == "luminance";
  const std::vector<std::string> names = film.channels();
  const size_t alpha = is_luminance ? 1 : 3;
  if (names.size() > alpha && names[alpha] == "A") of.colors += is_luminance ? "_alpha" : "a";
  headers[0].setName("picture");
  headers[0].setType(Imf::SCANLINEIMAGE);
  headers[0].insert(kPartAttribute,
                    Imf::StringAttribute(fmt::format("{}/{}", part.index + 1, part.count)));
  headers[0].insert(kFilmAttribute, Imf::StringAttribute(text_of(of)));
  Imf::Header& halves = headers[1];
  halves = Imf::Header(image_file.header().displayWindow(), image_file.header().dataWindow());
  halves.compression() = Imf::ZIP_COMPRESSION;
  halves.setName("sums");
  halves.setType(Imf::SCANLINEIMAGE);
  for_each_half(columns, [&](const std::string& name, size_t, const SumColumns&, size_t) {
    halves.channels().insert(name, Imf::Channel(Imf::UINT));
  });
  write_by_openexr(path, [&](Imf::OStream& stream) {
    Imf::MultiPartOutputFile file(stream, headers, 2);
    Imf::OutputPart first(file, 0), second(file, 1);
    first.copyPixels(image_file);
    second.setFrameBuffer(
        half_slices(columns, halves.dataWindow().min, crop.width(), crop.height()));
    second.writePixels(crop.height());
  });
}

}  // namespace kinome
