#include "open_image.h"

#include <dlfcn.h>

#include <filesystem>

#include "kinome/instruction_set.h"
#include "kinome/log.h"

namespace kinome {
namespace {

/// Of the plugin that this is linked to, whichever instruction set that is built for.
std::filesystem::path plugin_folder() {
  Dl_info info{};
  static const char anchor = 0;
  dladdr(&anchor, &info);
  const auto folder = std::filesystem::path(info.dli_fname ? info.dli_fname : "").parent_path();
  return instruction_set_named(folder.filename().string()) ? folder.parent_path() : folder;
}

ReadImageFunction image_reader(const Properties& props) {
  const std::string library = (plugin_folder() / kReadImageLibrary).lexically_normal().string();
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = handle ? dlsym(handle, kReadImageSymbol) : nullptr;
  if (!symbol) {
    const char* const reason = dlerror();
    throw props.error("filename", std::string("needs OpenImageIO, which can't be loaded: ") +
                                      (reason ? reason : library));
  }
  return reinterpret_cast<ReadImageFunction>(symbol);
}

}  // namespace

StoredImage open_image(const std::string& path, const Properties& props) {
  StoredImage image;
  std::string error;
  if (!image_reader(props)(path.c_str(), image, error)) {
    throw Error(Location{path}, "can't be read as an image: " + error);
  }
  log_unused(path, image.unused);
  return image;
}

}  // namespace kinome
