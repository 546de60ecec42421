#include "crash.h"

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <unwind.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <mutex>

#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include "kinome/output_files.h"
#include "kinome/alternate_stack.h"
#include "kinome/image.h"
#include "kinome/plugin_sites.h"

namespace kinome::app {
namespace {

#ifdef KINOME_HAS_SANITIZER
constexpr bool kHasSanitizer = true;
#else
constexpr bool kHasSanitizer = false;
#endif

struct Crash {
  int signal;
  const char* name;
};
constexpr Crash kCrashes[] = {{SIGSEGV, "SIGSEGV"},
                              {SIGBUS, "SIGBUS"},
                              {SIGFPE, "SIGFPE"},
                              {SIGILL, "SIGILL"},
                              {SIGABRT, "SIGABRT"}};

std::atomic<const char*> current_activity{"starting"};
std::atomic<bool> is_terminal{false};
std::atomic<pid_t> crashing_thread{0};
static_assert(std::atomic<const char*>::is_always_lock_free &&
              std::atomic<pid_t>::is_always_lock_free);

/// Instruction and stack pointer at a signal; nullptr on unsupported processors.
struct Registers {
  const void* instruction = nullptr;
  const void* stack = nullptr;
  explicit Registers(const void* context) {
    const auto& at = static_cast<const ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
    instruction = reinterpret_cast<const void*>(at.gregs[REG_RIP]);
    stack = reinterpret_cast<const void*>(at.gregs[REG_RSP]);
#elif defined(__aarch64__)
    instruction = reinterpret_cast<const void*>(at.pc);
    stack = reinterpret_cast<const void*>(at.sp);
#else
    static_cast<void>(at);
#endif
  }
};

/// The innermost plugin on the call stack.
struct Culprit {
  const char* plugin = nullptr;
  bool is_by_core = false;  ///< true if the plugin called the core, and that crashed
  int frames = 0;
};

_Unwind_Reason_Code look_at_frame(_Unwind_Context* context, void* data) {
  constexpr int kMaxFrames = 4096;
  auto& culprit = *static_cast<Culprit*>(data);
  const auto* const address = reinterpret_cast<const void*>(_Unwind_GetIP(context));
  culprit.plugin = plugin_at(address);
  culprit.is_by_core = culprit.is_by_core || is_core_at(address);
  return culprit.plugin || ++culprit.frames == kMaxFrames ? _URC_END_OF_STACK : _URC_NO_REASON;
}

/// Finds the plugin that crashed. _Unwind_Backtrace allocates no memory, and takes no locks if the
/// C library has _dl_find_object (glibc 2.35). It may itself crash on a corrupt stack, which
/// handle_crash() expects.
Culprit find_culprit(const Registers& at) {
  Culprit culprit;
  culprit.plugin = plugin_at(at.instruction);
  if (culprit.plugin) return culprit;
#if defined(__x86_64__)
  // After a call through a null pointer there is no code to unwind from, but the return address is
  // on top of the stack.
  if (!at.instruction && at.stack) {
    culprit.plugin = plugin_at(*static_cast<const void* const*>(at.stack));
    if (culprit.plugin) return culprit;
  }
#endif
  _Unwind_Backtrace(look_at_frame, &culprit);
  if (!culprit.plugin) culprit = {plugin_being_loaded(), false, 0};
  return culprit;
}

/// A line of text in a fixed buffer, which needs neither allocation nor stdio.
class Line {
 public:
  Line& operator<<(const char* text) {
    const size_t length = std::min(std::strlen(text), text_.size() - length_);
    std::memcpy(text_.data() + length_, text, length);
    length_ += length;
    return *this;
  }
  void write() const {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text_.data(), length_);
  }

 private:
  std::array<char, 512> text_{};
  size_t length_ = 0;
};

bool is_stack_overflow(int signal, const siginfo_t& info, const Registers& at) {
  if (signal != SIGSEGV || info.si_code <= 0 || !at.stack) return false;
  constexpr std::ptrdiff_t kNear = 1 << 16;
  const auto distance = static_cast<std::ptrdiff_t>(reinterpret_cast<uintptr_t>(info.si_addr) -
                                                    reinterpret_cast<uintptr_t>(at.stack));
  return distance > -kNear && distance < kNear;
}

void report(int signal, const siginfo_t& info, const Registers& at, const Culprit& culprit) {
  Line line;
  if (is_terminal) line << "\r\x1b[K";  // overwrites the progress bar
  line << "kinome: ";
  const bool is_plugins = culprit.plugin && !culprit.is_by_core;
  if (is_plugins) line << "plugin '" << culprit.plugin << "' ";
  line << "crashed (";
  for (const Crash& crash : kCrashes) {
    if (crash.signal == signal) line << crash.name;
  }
  if (is_stack_overflow(signal, info, at)) line << ", stack overflow";
  line << ") while " << current_activity.load();
  if (culprit.plugin && !is_plugins) line << ", called by plugin '" << culprit.plugin << "'";
  line << "\n";
  line.write();
}

/// Reports a crash and ends the program. Other threads that crash meanwhile wait. If the search for
/// the plugin crashes, the same thread enters again and reports the crash without a plugin.
extern "C" void handle_crash(int signal, siginfo_t* info, void* context) {
  const auto self = static_cast<pid_t>(syscall(SYS_gettid));
  pid_t first = 0;
  const bool is_first = crashing_thread.compare_exchange_strong(first, self);
  if (!is_first && first != self) {
    while (true) pause();
  }
  const Registers at(context);
  remove_temporary_files();
  report(signal, *info, at, is_first ? find_culprit(at) : Culprit{});
  for (const Crash& crash : kCrashes) std::signal(crash.signal, SIG_DFL);
  raise(signal);
}

/// Call stack of a throw, which is unwound by the time the exception is reported.
struct Throw {
  const void* exception = nullptr;
  std::array<void*, 48> frames{};
  int count = 0;
  const char* being_loaded = nullptr;  ///< plugin whose code isn't registered yet
};
std::atomic<bool> is_watching_throws{false};
std::mutex throws_mutex;
std::array<Throw, 64> throws;
size_t next_throw = 0;

void note_throw(const void* exception) {
  Throw noted;
  noted.exception = exception;
  noted.count = backtrace(noted.frames.data(), static_cast<int>(noted.frames.size()));
  noted.being_loaded = plugin_being_loaded();
  const std::lock_guard lock(throws_mutex);
  throws[next_throw++ % throws.size()] = noted;
}

}  // namespace

void install_crash_handlers() {
  if (kHasSanitizer) return;
  is_terminal = isatty(STDERR_FILENO) == 1;
  static const AlternateStack stack;  // for this thread; the core's threads have their own
  // The first unwinding loads libraries and allocates memory, which a handler must not do.
  Culprit none;
  _Unwind_Backtrace(look_at_frame, &none);
  for (const Crash& crash : kCrashes) {
    struct sigaction action {};
    action.sa_sigaction = handle_crash;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_NODEFER;
    sigaction(crash.signal, &action, nullptr);
  }
}

void set_activity(const char* activity) {
  current_activity = activity;
}

void watch_throws() {
  is_watching_throws = true;
}

std::string plugin_that_threw(const void* exception) {
  const std::lock_guard lock(throws_mutex);
  for (size_t back = 1; back <= std::min(next_throw, throws.size()); ++back) {
    const Throw& found = throws[(next_throw - back) % throws.size()];
    if (exception && found.exception != exception) continue;
    for (int i = 0; i < found.count; ++i) {
      const char* const plugin = plugin_at(found.frames[static_cast<size_t>(i)]);
      if (plugin) return plugin;
    }
    return found.being_loaded ? found.being_loaded : "";
  }
  return {};
}

}  // namespace kinome::app

/// Replaces the C++ library's function, which every throw calls, and forwards to it.
extern "C" void __cxxabiv1::__cxa_throw(void* exception, std::type_info* type,
                                        void (*destroy)(void*)) {
  using Throws = void (*)(void*, std::type_info*, void (*)(void*));
  static const auto next = reinterpret_cast<Throws>(dlsym(RTLD_NEXT, "__cxa_throw"));
  if (kinome::app::is_watching_throws) kinome::app::note_throw(exception);
  next(exception, type, destroy);
  __builtin_unreachable();
}
