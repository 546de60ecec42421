#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/render.h"

namespace kinome::test {

using Clock = std::chrono::steady_clock;

/// The program in the background, with its stderr in a file.
class Background {
 public:
  Background(const std::vector<std::string>& arguments, std::string log) : log_(std::move(log)) {
    std::vector<char*> argv = {const_cast<char*>(KINOME_TEST_PROGRAM)};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    const int file = open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, STDERR_FILENO);
    dup2(file, STDOUT_FILENO);
    signal(SIGINT, SIG_DFL);  // tests may run in a shell's background, whose programs ignore it
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~Background() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

  void send(int signal) const { ::kill(pid_, signal); }
  std::string log() const {
    std::ifstream file(log_);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  /// Waits until the log contains `text` at least `times` times.
  ::testing::AssertionResult says(const std::string& text, int times = 1) const {
    const auto count = [&text](const std::string& log) {
      int found = 0;
      for (size_t at = 0; (at = log.find(text, at)) != std::string::npos; ++at) ++found;
      return found;
    };
    const auto deadline = Clock::now() + std::chrono::seconds(600);
    while (Clock::now() < deadline) {
      if (count(log()) >= times) return ::testing::AssertionSuccess();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return ::testing::AssertionFailure() << "didn't say '" << text << "' but: " << log();
  }
  /// Returns the exit status, 128 + signal if a signal ended it, or -1 after a time limit.
  int wait() {
    const auto deadline = Clock::now() + std::chrono::seconds(1200);
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (Clock::now() > deadline) return -1;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  std::string log_;
  pid_t pid_;
};

}  // namespace kinome::test
