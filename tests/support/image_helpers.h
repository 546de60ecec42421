#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "kinome/sampler.h"
#include "support/render.h"

namespace kinome::test {

inline Image make_image(int width, int height, std::vector<std::string> channels) {
  Image image{width, height, std::move(channels), {}};
  image.data.resize(static_cast<size_t>(width) * height * image.channels.size());
  for (size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = 100 * to_unit_float(static_cast<uint32_t>(hash_words(i) >> 32)) - 10;
  }
  return image;
}

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline int file_count(const std::string& folder) {
  using Files = std::filesystem::directory_iterator;
  return static_cast<int>(std::distance(Files(folder), Files()));
}

/// Runs `f`, expects an Error that names `path` and contains `part`; returns its text.
template <class F>
std::string expect_error(const F& f, const std::string& path, const std::string& part) {
  try {
    f();
  } catch (const Error& e) {
    const std::string what = e.what();
    EXPECT_NE(what.find(path), std::string::npos) << what;
    EXPECT_NE(what.find(part), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    return what;
  }
  ADD_FAILURE() << "no error for " << path << " (" << part << ")";
  return {};
}

}  // namespace kinome::test
