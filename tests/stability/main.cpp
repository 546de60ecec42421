// kinome-stability [--short] [--page FILE] [--only NUMBER]...
//
// Renders the matrix of matrix.h on all processors and reports differences. The last line is `N
// passed, M failed`, and the exit status agrees with it. --page writes the page; --short skips long
// cases and uses one material per scene; --only selects cases.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>
#include <thread>

#include <fmt/format.h>

#include "kinome/output_files.h"
#include "kinome/error.h"
#include "kinome/image.h"
#include "kinome/log.h"
#include "matrix.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;

struct Options {
  bool is_short = false;
  std::string page;
  std::set<int> only;
};

std::string to_line(const Cell& cell) {
  std::string text = cell.text;
  std::replace(text.begin(), text.end(), '\n', ' ');
  return fmt::format("{} {:a} {:a} {} {:a} {:a} {}", static_cast<int>(cell.verdict), cell.worst_z,
                     cell.p, cell.non_finite, cell.kurtosis, cell.largest, text);
}
bool read_line(std::istream& in, Cell& cell) {
  std::string line;
  if (!std::getline(in, line)) return false;
  std::istringstream words(line);
  int verdict = 0;
  std::string z, p, kurtosis, largest;
  if (!(words >> verdict >> z >> p >> cell.non_finite >> kurtosis >> largest)) return false;
  cell.verdict = static_cast<Cell::Verdict>(verdict);
  cell.worst_z = std::strtod(z.c_str(), nullptr);
  cell.p = std::strtod(p.c_str(), nullptr);
  cell.kurtosis = std::strtod(kurtosis.c_str(), nullptr);
  cell.largest = std::strtod(largest.c_str(), nullptr);
  std::getline(words >> std::ws, cell.text);
  return true;
}

/// Writes all cells of a row, one per line. Rows run in processes, because the tests' registry of
/// plugins isn't thread-safe, and a crash then loses only one row.
void run_row(const Row& row, const std::string& file) {
  std::ofstream out(file);
  for (const Method& method : methods()) {
    for (const Material& material : row.trial->materials) {
      out << to_line(run_cell(*row.trial, method, material)) << "\n";
    }
  }
}

void collect_row(Row& row, const std::string& file) {
  std::ifstream in(file);
  for (size_t m = 0; m < methods().size(); ++m) {
    row.cells.emplace_back(row.trial->materials.size());
    for (Cell& cell : row.cells.back()) {
      if (read_line(in, cell)) continue;
      cell.verdict = Cell::Verdict::kDiffers;
      cell.text = "the program ended";
    }
  }
}

void run_rows(std::vector<Row>& rows, const std::string& folder) {
  const auto file = [&](size_t i) { return folder + "/row" + std::to_string(i); };
  const unsigned most = std::max(1u, std::thread::hardware_concurrency());
  unsigned running = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (running == most) {
      wait(nullptr);
      --running;
    }
    const pid_t child = fork();
    if (child == 0) {
      run_row(rows[i], file(i));
      _exit(0);
    }
    ++running;
  }
  while (wait(nullptr) > 0) {
  }
  for (size_t i = 0; i < rows.size(); ++i) collect_row(rows[i], file(i));
}

/// Returns the number of tests that the page refers to but that don't exist.
int missing_tests(const std::vector<Case>& cases) {
  int missing = 0;
  for (const Case& c : cases) {
    std::istringstream words(c.tests);
    std::string word;
    while (words >> word) {
      if (fs::exists(std::string(KINOME_TEST_SOURCE) + "/tests/" + word)) continue;
      std::cout << "case " << c.number << " refers to tests/" << word << ", which doesn't exist\n";
      ++missing;
    }
  }
  return missing;
}

int run(const Options& options) {
  const TemporaryFolder folder;
  std::vector<Case> cases;
  for (const auto& make : {light_cases, surface_cases, lamp_cases}) {
    for (Case& c : make(folder.folder())) {
      if (options.only.empty() || options.only.contains(c.number)) cases.push_back(std::move(c));
    }
  }
  std::sort(cases.begin(), cases.end(),
            [](const Case& a, const Case& b) { return a.number < b.number; });
  std::vector<Row> rows;
  for (Case& c : cases) {
    if (options.is_short) {
      std::erase_if(c.trials, [](const Trial& t) { return t.is_long; });
      size_t turn = static_cast<size_t>(c.number);
      for (Trial& trial : c.trials) {
        // A different material for each trial.
        trial.materials = {trial.materials[turn++ % trial.materials.size()]};
      }
    }
  }
  for (const Case& c : cases) {
    for (const Trial& trial : c.trials) rows.push_back({&c, &trial, {}});
  }
  run_rows(rows, folder.folder());

  int failed = missing_tests(cases), good = 0;
  for (const Row& row : rows) {
    for (size_t m = 0; m < methods().size(); ++m) {
      for (size_t k = 0; k < row.trial->materials.size(); ++k) {
        const Cell& cell = row.cells[m][k];
        if (cell.verdict == Cell::Verdict::kNotApplicable) continue;
        (passed(cell) ? good : failed) += 1;
        if (passed(cell)) continue;
        std::cout << fmt::format("case {}, {}, {}, {}: z = {:.2f}, p = {:.2g}: {}\n",
                                 row.of->number, row.trial->name, methods()[m].name,
                                 row.trial->materials[k].name, cell.worst_z, cell.p, cell.text);
      }
    }
  }
  if (!options.page.empty()) write_text(options.page, stability_page(cases, rows));
  std::cout << good << " passed, " << failed << " failed\n";
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace kinome::test

int main(int argc, char** argv) {
  kinome::test::Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--short") {
      options.is_short = true;
    } else if (argument == "--page" && i + 1 < argc) {
      options.page = argv[++i];
    } else if (argument == "--only" && i + 1 < argc) {
      options.only.insert(std::atoi(argv[++i]));
    } else {
      std::cerr << "kinome-stability [--short] [--page FILE] [--only NUMBER]...\n";
      return 2;
    }
  }
  if (!options.page.empty() && (options.is_short || !options.only.empty())) {
    std::cerr << "kinome-stability: --page is for all cases\n";
    return 2;
  }
  // Warnings such as those about negative texels are expected here.
  kinome::set_log_level(kinome::LogLevel::kQuiet);
  setenv("KINOME_PLUGIN_PATH", KINOME_STABILITY_PLUGINS, 1);
  try {
    return kinome::test::run(options);
  } catch (const kinome::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
