// A library with the functions of Open Image Denoise that Kinome calls, for tests on machines
// without it. Its filter returns the image times 2 for colours, and copies other images. The
// environment variable FAKE_OIDN selects a fault: "old" (version 1), "broken" (execution fails).
// It prints each execution to stderr if FAKE_OIDN is "log".

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

#define FAKE extern "C" __attribute__((visibility("default")))

namespace {

bool is(const char* mode) {
  const char* const value = std::getenv("FAKE_OIDN");
  return value && std::strcmp(value, mode) == 0;
}

struct FakeDevice {
  int threads = 0;
  bool is_broken = false;
};

struct FakeFilter {
  FakeDevice* device;
  std::map<std::string, float*> images;
  std::map<std::string, bool> flags;
  size_t values = 0;
};

}  // namespace

FAKE FakeDevice* oidnNewDevice(int) {
  return new FakeDevice;
}
FAKE void oidnSetDeviceInt(FakeDevice* device, const char* name, int value) {
  if (std::strcmp(name, "numThreads") == 0) device->threads = value;
}
FAKE void oidnSetDeviceBool(FakeDevice*, const char*, bool) {}
FAKE int oidnGetDeviceInt(FakeDevice*, const char* name) {
  return std::strcmp(name, "versionMajor") == 0 ? (is("old") ? 1 : 2) : 0;
}
FAKE void oidnCommitDevice(FakeDevice*) {}
FAKE int oidnGetDeviceError(FakeDevice* device, const char** message) {
  if (!device->is_broken) return 0;
  *message = "the fake is broken";
  return 1;
}
FAKE void oidnReleaseDevice(FakeDevice* device) {
  delete device;
}
FAKE FakeFilter* oidnNewFilter(FakeDevice* device, const char*) {
  return new FakeFilter{device, {}, {}};
}
FAKE void oidnSetSharedFilterImage(FakeFilter* filter, const char* name, void* data, int,
                                   size_t width, size_t height, size_t, size_t, size_t) {
  filter->images[name] = static_cast<float*>(data);
  filter->values = 3 * width * height;
}
FAKE void oidnSetFilterBool(FakeFilter* filter, const char* name, bool value) {
  filter->flags[name] = value;
}
FAKE void oidnCommitFilter(FakeFilter*) {}
FAKE void oidnExecuteFilter(FakeFilter* filter) {
  filter->device->is_broken = is("broken");
  std::string inputs;
  const float* input = nullptr;
  for (const auto& [name, image] : filter->images) {
    if (name == "output") continue;
    inputs += name + " ";
    if (!input || name == "color") input = image;
  }
  const float factor = filter->images.count("color") != 0 ? 2 : 1;
  for (size_t i = 0; i < filter->values; ++i) filter->images["output"][i] = factor * input[i];
  if (!is("log")) return;
  for (const auto& [name, value] : filter->flags) inputs += name + (value ? "=1 " : "=0 ");
  std::fprintf(stderr, "fake: %sthreads=%d\n", inputs.c_str(), filter->device->threads);
}
FAKE void oidnReleaseFilter(FakeFilter* filter) {
  delete filter;
}
