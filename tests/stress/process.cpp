#include "process.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>

#include <fmt/format.h>

namespace kinome::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr rlim_t kMemory = rlim_t{4} << 30;

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

void write_report(const CheckReport& report, const std::string& file) {
  std::ofstream out(file);
  out << report.comparisons << " " << report.open << "\n" << one_line(report.refused) << "\n";
  for (const std::string& excuse : report.excuses) out << "excuse\t" << one_line(excuse) << "\n";
  for (const Finding& f : report.findings) {
    out << f.kind << "\t" << f.method << "\t" << one_line(f.text) << "\n";
  }
  out << "end\n";
}
bool read_report(const std::string& file, CheckReport& report) {
  std::ifstream in(file);
  std::string line;
  if (!(in >> report.comparisons >> report.open) || !std::getline(in, line)) return false;
  std::getline(in, report.refused);
  while (std::getline(in, line)) {
    if (line == "end") return true;
    std::istringstream parts(line);
    Finding f;
    std::getline(parts, f.kind, '\t');
    if (f.kind == "excuse") {
      std::getline(parts, report.excuses.emplace_back());
      continue;
    }
    std::getline(parts, f.method, '\t');
    std::getline(parts, f.text);
    report.findings.push_back(f);
  }
  return false;
}

[[noreturn]] void run_child(const std::string& folder, const std::string& file,
                            const std::function<CheckReport(const std::string&)>& work) {
  // Sanitizers map far more memory than they use.
  if (std::string_view(KINOME_TEST_SANITIZER).empty()) {
    const rlimit memory{kMemory, kMemory};
    setrlimit(RLIMIT_AS, &memory);
  }
  const rlimit core{0, 0};
  setrlimit(RLIMIT_CORE, &core);
  try {
    write_report(work(folder), file);
  } catch (const std::exception& error) {
    CheckReport report;
    report.findings.push_back({"exception", "load", error.what()});
    write_report(report, file);
  }
  _exit(0);
}

std::string report_file(const std::string& folder) {
  return folder + "/report";
}

}  // namespace

Check::Check(std::string folder, const std::function<CheckReport(const std::string& folder)>& work,
             double patience)
    : folder_(std::move(folder)), patience_(patience), start_(Clock::now()) {
  std::filesystem::create_directories(folder_);
  // A check that ends without a report must not be judged by an earlier report.
  std::filesystem::remove(report_file(folder_));
  child_ = fork();
  if (child_ < 0) {
    child_ = 0;
    throw std::system_error(errno, std::generic_category(), "fork");
  }
  if (child_ == 0) run_child(folder_, report_file(folder_), work);
}

Check::~Check() {
  if (child_ == 0) return;
  kill(child_, SIGKILL);
  waitpid(child_, nullptr, 0);
}

bool Check::poll() {
  if (child_ == 0) return true;
  int status = 0;
  const pid_t ended = waitpid(child_, &status, WNOHANG);
  if (ended == 0) {
    if (std::chrono::duration<double>(Clock::now() - start_).count() < patience_) return false;
    kill(child_, SIGKILL);
    waitpid(child_, &status, 0);
    child_ = 0;
    report_.findings.push_back({"hang", "", fmt::format("more than {} s", patience_)});
    return true;
  }
  if (ended < 0) throw std::system_error(errno, std::generic_category(), "waitpid");
  child_ = 0;
  if (WIFSIGNALED(status)) {
    report_.findings.push_back({"crash", "", fmt::format("signal {}", WTERMSIG(status))});
  } else if (status != 0 || !read_report(report_file(folder_), report_)) {
    report_.findings.push_back({"crash", "", fmt::format("exit status {}", status)});
  }
  return true;
}

const CheckReport& Check::wait() {
  while (!poll()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return report_;
}

}  // namespace kinome::test
