#include "kinome/output_files.h"
#include "kinome/checkpoint.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "base/fnv1a.h"
#include "kinome/film.h"
#include "kinome/image.h"
#include "kinome/log.h"
#include "output_files/file_writer.h"

namespace kinome {
namespace {

namespace fs = std::filesystem;

// File format: kMagic, kFormat, the identity, the passes, the decisions, the film, and the hash of
// all bytes before it. Numbers have 8 bytes. A text is its length, followed by its bytes.
constexpr std::string_view kMagic = "kinome checkpoint\n";
constexpr uint64_t kFormat = 1;
/// State of a pass's items: none, all or some are done. kSome is followed by one bit per item.
constexpr uint64_t kNone = 0, kAll = 1, kSome = 2;

Error file_error(const std::string& path, const std::string& why) {
  return Error(fmt::format("checkpoint '{}': {}", path, why));
}

class Writer {
 public:
  explicit Writer(FileWriter& file) : file_(file) {}
  void bytes(const void* data, size_t count) {
    hash_.add(data, count);
    file_.write(data, count);
  }
  template <class Number>
  void number(Number value) {
    static_assert(sizeof(Number) == 8);
    bytes(&value, sizeof value);
  }
  void text(const std::string& text) {
    number(uint64_t{text.size()});
    bytes(text.data(), text.size());
  }
  void finish() { number(hash_.value()); }

 private:
  FileWriter& file_;
  Fnv1a hash_;
};

/// Reads a checkpoint. Checks all sizes, because a file may be forged, including its checksum.
class Reader {
 public:
  /// Throws Error if the file isn't a checkpoint, has another format, or is damaged.
  explicit Reader(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    file_.seekg(0, std::ios::end);
    const auto size = static_cast<uint64_t>(std::max<std::streamoff>(0, file_.tellg()));
    file_.seekg(0);
    std::string magic(std::min<uint64_t>(size, kMagic.size()), '\0');
    file_.read(magic.data(), static_cast<std::streamsize>(magic.size()));
    if (!file_) throw file_error(path, "it can't be read");
    if (magic.empty() || magic != kMagic.substr(0, magic.size())) {
      throw file_error(path, "it is not a checkpoint");
    }
    if (size < kMagic.size() + 2 * sizeof(uint64_t)) throw damaged();
    left_ = size - magic.size();
    // Check the format before the checksum, because another format may have another checksum.
    const auto format = number<uint64_t>();
    if (format != kFormat) {
      throw file_error(path, fmt::format("its format is {}, but this program supports only {}",
                                         format, kFormat));
    }
    check_hash(size - sizeof(uint64_t));
    left_ -= sizeof(uint64_t);
  }

  void bytes(void* data, size_t count) {
    if (count > left_) throw wrong_render();
    file_.read(static_cast<char*>(data), static_cast<std::streamsize>(count));
    if (!file_) throw wrong_render();
    left_ -= count;
  }
  template <class Number>
  Number number() {
    static_assert(sizeof(Number) == 8);
    Number value;
    bytes(&value, sizeof value);
    return value;
  }
  /// Throws Error if the file can't contain `count` items of `bits` bits. Called before allocating
  /// memory for them.
  void expect(uint64_t count, uint64_t bits) const {
    if (count / 8 > left_ / bits) throw wrong_render();
  }
  uint64_t count(uint64_t bits) {
    const auto count = number<uint64_t>();
    expect(count, bits);
    return count;
  }
  std::string text() {
    std::string text(count(8), '\0');
    bytes(text.data(), text.size());
    return text;
  }
  void finish() const {
    if (left_ != 0) throw wrong_render();
  }
  Error damaged() const { return file_error(path_, "it is damaged: its checksum is wrong"); }
  /// Error for contents that don't fit this render though the checksum is right.
  Error wrong_render() const { return file_error(path_, "it belongs to another render"); }

 private:
  void check_hash(uint64_t size) {
    const auto position = file_.tellg();
    file_.seekg(0);
    Fnv1a hash;
    std::vector<char> block(1 << 20);
    while (size > 0) {
      const size_t count = std::min<uint64_t>(size, block.size());
      if (!file_.read(block.data(), static_cast<std::streamsize>(count))) throw damaged();
      hash.add(block.data(), count);
      size -= count;
    }
    uint64_t found = 0;
    file_.read(reinterpret_cast<char*>(&found), sizeof found);
    if (!file_ || found != hash.value()) throw damaged();
    file_.seekg(position);
  }

  const std::string& path_;
  std::ifstream file_;
  uint64_t left_ = 0;  ///< unread bytes; without the checksum once it has been checked
};

void check_identity(const std::string& path, const Checkpoint::Identity& theirs,
                    const Checkpoint::Identity& ours) {
  const auto value = [](const Checkpoint::Identity& of, const std::string& name) {
    const auto found = of.find(name);
    return found == of.end() ? std::string("not given") : "'" + found->second + "'";
  };
  Checkpoint::Identity both = theirs;
  both.insert(ours.begin(), ours.end());
  for (const auto& [name, unused] : both) {
    const std::string there = value(theirs, name), here = value(ours, name);
    if (there == here) continue;
    if (name == Checkpoint::kScene) {
      throw file_error(path,
                       "it belongs to another render: its scene has changed, in the scene files or "
                       "in the values of -D");
    }
    throw file_error(path, fmt::format("it belongs to another render: its {} is {}, expected {}",
                                       name, there, here));
  }
}

}  // namespace

Checkpoint::Checkpoint(Options options) : options_(std::move(options)) {
  check_writable(options_.path);
  std::error_code failed;
  if (!fs::exists(options_.path, failed)) return;
  if (!options_.resume) {
    throw file_error(options_.path,
                     "it exists: add --resume to continue from it, or remove it to start again");
  }
  const Reader check(options_.path);
  resumes_ = true;
}

void Checkpoint::begin(Film& film) {
  passes_.clear();
  decisions_.clear();
  next_pass_ = next_decision_ = 0;
  commits_ = film.commits();
  closed_ = false;
  if (resumes_) {
    read_file(film);
    if (options_.on_resume) options_.on_resume();
  }
  written_ = Clock::now();
}

void Checkpoint::begin_pass(size_t items) {
  if (closed_) return;
  if (next_pass_ == passes_.size()) {
    passes_.push_back({items, 0, {}});
  } else if (passes_[next_pass_].items != items) {
    throw file_error(options_.path, "it belongs to another render: its passes differ");
  }
  ++next_pass_;
}

bool Checkpoint::is_done(size_t item) const {
  if (closed_ || next_pass_ == 0) return false;
  const Pass& pass = passes_[next_pass_ - 1];
  return item < pass.items && pass.has(item);
}

void Checkpoint::add(Film& film, size_t item, uint64_t commits) {
  commits_ += commits;
  if (closed_) return;
  Pass& pass = passes_.at(next_pass_ - 1);
  if (pass.done.empty()) pass.done.resize(pass.items);
  pass.done.at(item) = true;
  if (++pass.done_count == pass.items) pass.done = {};
  if (std::chrono::duration<double>(Clock::now() - written_).count() >= options_.every) {
    write(film);
  }
}

double Checkpoint::decide(const std::function<double()>& decide) {
  if (next_decision_ == decisions_.size()) {
    const double decision = decide();
    if (closed_) return decision;
    decisions_.push_back(decision);
  }
  return decisions_[next_decision_++];
}

void Checkpoint::close(Film& film) {
  if (closed_) return;
  write(film);
  closed_ = true;
}

void Checkpoint::remove() const {
  std::error_code failed;
  fs::remove(options_.path, failed);
}

bool Checkpoint::is_written_to(const std::string& path) const {
  return are_written_to_one_file(options_.path, path);
}

void Checkpoint::write(Film& film) {
  try {
    write_file(film);
    last_failure_.clear();
  } catch (const std::exception& error) {
    // Warn only once about an error that recurs.
    if (last_failure_ != error.what()) {
      last_failure_ = error.what();
      log_warn(fmt::format("{}; the render continues without it", error.what()));
    }
  }
  written_ = Clock::now();
}

void Checkpoint::write_file(Film& film) const {
  if (film.commits() != commits_) {
    throw file_error(options_.path,
                     "it can't be written: the integrator adds to the film without "
                     "Scheduler::commit()");
  }
  FileWriter file(options_.path);
  Writer out(file);
  out.bytes(kMagic.data(), kMagic.size());
  out.number(kFormat);
  out.number(uint64_t{identity_.size()});
  for (const auto& [name, value] : identity_) {
    out.text(name);
    out.text(value);
  }
  out.number(uint64_t{passes_.size()});
  for (const Pass& pass : passes_) {
    out.number(pass.items);
    out.number(pass.done.empty() ? (pass.done_count > 0 ? kAll : kNone) : kSome);
    std::string bits((pass.done.size() + 7) / 8, '\0');
    for (size_t i = 0; i < pass.done.size(); ++i) {
      if (pass.done[i]) bits[i / 8] = static_cast<char>(bits[i / 8] | 1 << i % 8);
    }
    out.bytes(bits.data(), bits.size());
  }
  out.number(uint64_t{decisions_.size()});
  for (const double decision : decisions_) out.number(decision);
  film.transfer([&](void* bytes, size_t count) { out.bytes(bytes, count); });
  out.finish();
  file.commit(true);
}

void Checkpoint::read_file(Film& film) {
  Reader in(options_.path);
  Identity theirs;
  for (uint64_t i = in.count(128); i > 0; --i) {
    std::string name = in.text();
    theirs[std::move(name)] = in.text();
  }
  check_identity(options_.path, theirs, identity_);
  for (uint64_t left = in.count(128); left > 0; --left) {
    Pass pass;
    pass.items = in.number<uint64_t>();
    const auto done = in.number<uint64_t>();
    if (done == kSome) {
      in.expect(pass.items, 1);
      std::string bits(pass.items / 8 + (pass.items % 8 > 0 ? 1 : 0), '\0');
      in.bytes(bits.data(), bits.size());
      pass.done.resize(pass.items);
      for (size_t i = 0; i < pass.items; ++i) {
        pass.done[i] = (bits[i / 8] >> i % 8 & 1) != 0;
        pass.done_count += pass.done[i] ? 1 : 0;
      }
    } else {
      pass.done_count = done == kAll ? pass.items : 0;
    }
    passes_.push_back(std::move(pass));
  }
  for (uint64_t i = in.count(64); i > 0; --i) decisions_.push_back(in.number<double>());
  if (!film.transfer([&](void* bytes, size_t count) { in.bytes(bytes, count); })) {
    throw in.wrong_render();
  }
  in.finish();
}

}  // namespace kinome
