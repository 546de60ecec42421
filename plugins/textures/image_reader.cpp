#include "image_reader.h"

#include "image_formats.h"
#include "kinome/export.h"

extern "C" KINOME_EXPORT bool kinome_read_image(const char* /*path*/, const std::string& bytes,
                                                kinome::StoredImage& image, std::string& error) {
  return kinome::report_errors(error, [&] {
    if (bytes.starts_with("\x89PNG")) {
      kinome::read_png(bytes, image);
    } else if (bytes.starts_with("\xff\xd8")) {
      kinome::read_jpeg(bytes, image);
    } else if (bytes.starts_with("#?")) {
      kinome::read_radiance(bytes, image);
    } else {
      return false;
    }
    return true;
  });
}
