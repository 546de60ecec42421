#include "options/options.h"

#include <iostream>
#include <memory>
#include <vector>

#include "fuzz.h"

/// Parses command lines: arguments with a line break after each.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::cout.setstate(std::ios::failbit);  // --help prints text
  std::vector<std::string> arguments = {"kinome"};
  std::string argument;
  for (size_t i = 0; i < size; ++i) {
    if (data[i] == 0) break;
    if (data[i] != '\n') {
      argument += static_cast<char>(data[i]);
    } else {
      arguments.push_back(std::move(argument));
      argument.clear();
    }
  }
  std::vector<const char*> argv;
  for (const std::string& text : arguments) argv.push_back(text.c_str());
  argv.push_back(nullptr);
  try {
    // The parser is reused, because building it takes longer than using it. It is rebuilt from time
    // to time, because CLI11 stores each option that it parsed.
    static std::unique_ptr<kinome::app::OptionsParser> parser;
    static unsigned runs = 0;
    if (runs++ % 100'000 == 0) parser = std::make_unique<kinome::app::OptionsParser>();
    parser->parse(static_cast<int>(arguments.size()), argv.data());
  } catch (const kinome::Error& error) {
    kinome::fuzz::refusal = error.what();
  }
  return 0;
}
