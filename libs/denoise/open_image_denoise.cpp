// Opens Open Image Denoise at run time. Kinome declares the few functions of its C interface that
// it calls itself, so that nothing needs its headers.
//
// The interface is that of version 2: setters have the type in their names
// (oidnSetFilterBool), and the library's name ends in .so.2 as long as the binary interface stays
// compatible. libOpenImageDenoise.so.2 needs libOpenImageDenoise_core.so of exactly its own
// version. The core opens libOpenImageDenoise_device_cpu.so, which has the processor's code, in the
// core's own folder. So the folder must be complete; the device also needs libtbb.so.12. It uses
// the TBB that Embree has loaded, if there is one.

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "kinome/denoise.h"
#include "kinome/error.h"
#include "kinome/log.h"

namespace kinome {
namespace {

namespace fs = std::filesystem;

struct OidnDevice;
struct OidnFilter;

constexpr const char* kLibraryName = "libOpenImageDenoise.so.2";
constexpr int kMajorVersion = 2;

/// Functions and constants of the library's C interface, by their names without the prefix.
struct OidnFunctions {
  using Device = OidnDevice*;
  using Filter = OidnFilter*;
  static constexpr int kCpu = 1;     ///< a device type
  static constexpr int kFloat3 = 3;  ///< an image format

  Device (*new_device)(int type) = nullptr;
  void (*set_device_int)(Device, const char* name, int value) = nullptr;
  void (*set_device_bool)(Device, const char* name, bool value) = nullptr;
  int (*get_device_int)(Device, const char* name) = nullptr;
  void (*commit_device)(Device) = nullptr;
  int (*get_device_error)(Device, const char** message) = nullptr;
  void (*release_device)(Device) = nullptr;
  Filter (*new_filter)(Device, const char* type) = nullptr;
  void (*set_filter_image)(Filter, const char* name, void* data, int format, size_t width,
                           size_t height, size_t offset, size_t pixel_stride,
                           size_t row_stride) = nullptr;
  void (*set_filter_bool)(Filter, const char* name, bool value) = nullptr;
  void (*commit_filter)(Filter) = nullptr;
  void (*execute_filter)(Filter) = nullptr;
  void (*release_filter)(Filter) = nullptr;
};

/// Returns the address of pyoidn's library below the prefix of a Python installation, for each of
/// its versions of Python. The package keeps all files of the library in pyoidn/oidn/lib.
std::vector<std::string> pyoidn_below(const fs::path& prefix) {
  std::vector<std::string> found;
  for (const char* const lib : {"lib", "local/lib"}) {
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(prefix / lib, failed)) {
      if (!entry.path().filename().string().starts_with("python3")) continue;
      for (const char* const packages : {"site-packages", "dist-packages"}) {
        const fs::path file = entry.path() / packages / "pyoidn/oidn/lib" / kLibraryName;
        if (fs::exists(file, failed)) found.push_back(file.string());
      }
    }
  }
  return found;
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

/// Returns the folder above the one of the first python3 in PATH, or "".
fs::path prefix_of_python() {
  const std::string path = variable("PATH");
  for (size_t begin = 0; begin < path.size();) {
    const size_t end = std::min(path.find(':', begin), path.size());
    const fs::path folder = path.substr(begin, end - begin);
    std::error_code failed;
    if (fs::exists(folder / "python3", failed)) return folder.parent_path();
    begin = end + 1;
  }
  return {};
}

/// Returns the paths at which the library may be, in the order of preference.
std::vector<std::string> paths_of_library(const std::string& given) {
  const auto in_folder = [](const std::string& path) {
    std::error_code failed;
    return fs::is_directory(path, failed) ? (fs::path(path) / kLibraryName).string() : path;
  };
  if (const std::string named = variable("KINOME_OIDN"); !named.empty()) return {in_folder(named)};
  std::vector<std::string> paths;
  if (!given.empty()) paths.push_back(in_folder(given));
  paths.emplace_back(kLibraryName);
  for (const fs::path& prefix : {fs::path(variable("VIRTUAL_ENV")), prefix_of_python(),
                                 fs::path(variable("HOME")) / ".local"}) {
    if (prefix.empty()) continue;
    for (std::string& path : pyoidn_below(prefix)) paths.push_back(std::move(path));
  }
  return paths;
}

Error missing_library(const std::string& why) {
  return Error("Open Image Denoise can't be loaded: " + why +
               "; `pip install pyoidn` into the current Python environment installs it, or "
               "KINOME_OIDN names its folder");
}

template <class Function>
void resolve(void* library, const char* name, Function& function) {
  void* const address = dlsym(library, name);
  if (!address) throw missing_library(std::string("it has no function ") + name);
  function = reinterpret_cast<Function>(address);
}

OidnFunctions functions_of(void* library) {
  OidnFunctions oidn;
  resolve(library, "oidnNewDevice", oidn.new_device);
  resolve(library, "oidnSetDeviceInt", oidn.set_device_int);
  resolve(library, "oidnSetDeviceBool", oidn.set_device_bool);
  resolve(library, "oidnGetDeviceInt", oidn.get_device_int);
  resolve(library, "oidnCommitDevice", oidn.commit_device);
  resolve(library, "oidnGetDeviceError", oidn.get_device_error);
  resolve(library, "oidnReleaseDevice", oidn.release_device);
  resolve(library, "oidnNewFilter", oidn.new_filter);
  resolve(library, "oidnSetSharedFilterImage", oidn.set_filter_image);
  resolve(library, "oidnSetFilterBool", oidn.set_filter_bool);
  resolve(library, "oidnCommitFilter", oidn.commit_filter);
  resolve(library, "oidnExecuteFilter", oidn.execute_filter);
  resolve(library, "oidnReleaseFilter", oidn.release_filter);
  return oidn;
}

/// Opens the library. It stays open until the program ends, because it has threads of its own.
OidnFunctions open_library(const std::string& given) {
  std::string why;
  for (const std::string& path : paths_of_library(given)) {
    if (void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      log_debug("denoising by " + path);
      return functions_of(library);
    }
    const char* const reason = dlerror();
    if (why.empty()) why = reason ? reason : "unknown reason";
  }
  throw missing_library(why);
}

/// A device, which runs filters on threads of its own. Not thread-safe.
class OidnRun {
 public:
  OidnRun(const OidnFunctions& oidn, unsigned threads)
      : oidn_(oidn), device_(oidn.new_device(OidnFunctions::kCpu), oidn.release_device) {
    if (!device_) check();
    if (threads > 0) oidn_.set_device_int(device_.get(), "numThreads", static_cast<int>(threads));
    // The render's own threads aren't bound to processors either.
    oidn_.set_device_bool(device_.get(), "setAffinity", false);
    oidn_.commit_device(device_.get());
    check();
    const int version = oidn_.get_device_int(device_.get(), "versionMajor");
    if (version != kMajorVersion) {
      throw missing_library("version " + std::to_string(version) + " is unsupported, expected " +
                            std::to_string(kMajorVersion));
    }
  }
  /// Filters the image named `name`, with the help of albedo and normal if they are not empty.
  std::vector<float> filter(const char* name, const DenoiserInput& input, std::vector<float>& image,
                            std::vector<float>* albedo, std::vector<float>* normal) {
    std::vector<float> output(image.size());
    const OidnFunctions::Filter filter = oidn_.new_filter(device_.get(), "RT");
    check();
    const auto set = [&](const char* which, std::vector<float>& values) {
      oidn_.set_filter_image(filter, which, values.data(), OidnFunctions::kFloat3,
                             static_cast<size_t>(input.width), static_cast<size_t>(input.height), 0,
                             0, 0);
    };
    set(name, image);
    set("output", output);
    if (albedo) set("albedo", *albedo);
    if (normal) set("normal", *normal);
    if (std::string(name) == "color") {
      oidn_.set_filter_bool(filter, "hdr", true);
      oidn_.set_filter_bool(filter, "cleanAux", albedo != nullptr);
    }
    oidn_.commit_filter(filter);
    oidn_.execute_filter(filter);
    oidn_.release_filter(filter);
    check();
    return output;
  }

 private:
  void check() {
    const char* message = nullptr;
    if (oidn_.get_device_error(device_.get(), &message) == 0) return;
    throw Error(std::string("Open Image Denoise failed: ") + (message ? message : "unknown error"));
  }

  const OidnFunctions& oidn_;
  std::unique_ptr<OidnDevice, void (*)(OidnFunctions::Device)> device_;
};

}  // namespace

Denoiser open_image_denoise(unsigned threads, const std::string& library) {
  static std::mutex mutex;
  static std::optional<OidnFunctions> loaded;
  const std::lock_guard lock(mutex);
  if (!loaded) loaded = open_library(library);
  return [&oidn = *loaded, threads](const DenoiserInput& input) {
    OidnRun run(oidn, threads);
    DenoiserInput own = input;  // the interface takes pointers to writable memory
    const bool has_albedo = !own.albedo.empty();
    const bool has_normal = has_albedo && !own.normal.empty();  // normals alone are unsupported
    if (has_albedo) own.albedo = run.filter("albedo", own, own.albedo, nullptr, nullptr);
    if (has_normal) own.normal = run.filter("normal", own, own.normal, nullptr, nullptr);
    return run.filter("color", own, own.color, has_albedo ? &own.albedo : nullptr,
                      has_normal ? &own.normal : nullptr);
  };
}

}  // namespace kinome
