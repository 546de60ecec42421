#include "session/picture.h"

#include "kinome/error.h"

namespace kinome::viewer {

void write_picture(const std::string& path, const Picture& picture) {
  if (path.ends_with(".png")) return write_png(path, picture.image, 0);
  if (!path.ends_with(".exr")) throw Error(Location{path}, "must end in .exr or .png");
  write_exr(path, picture.image, ExrNumber::kFloat,
            {{"integrator", picture.integrator},
             {"samples", std::to_string(static_cast<long>(picture.samples))}});
}

}  // namespace kinome::viewer
