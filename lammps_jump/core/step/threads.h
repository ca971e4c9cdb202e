// SPDX-License-Identifier: GPL-2.0-or-later
/* Threads that share the parts of a loop, and how many of them a run takes.

   The calling thread and its helpers take parts until none is left. Each begins with a share of its own, so that data
   stay in its cache, and goes on with parts that nobody has begun: a helper that the system does not run holds nobody
   up. Which thread does a part never changes a result: a part writes only what is its own. */

#ifndef JUMP_CORE_THREADS_H
#define JUMP_CORE_THREADS_H

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

#if defined(__wasm__)
#define JUMP_ONE_THREAD    // its standard library has none
#else
#include <condition_variable>
#include <mutex>
#include <thread>
#endif

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace jump {

using WallClock = std::chrono::steady_clock;

constexpr int MOST_THREADS = 64;
constexpr auto AWAKE = std::chrono::microseconds(60);     // a helper waits so long for a job before it sleeps
constexpr auto PATIENCE = std::chrono::microseconds(20);  // the caller waits so long before it offers its core
constexpr int LOOKS = 32;                                 // between two looks at the clock
inline std::atomic<int> threads_now{1};    // of the run of this process, for who looks on

/** Leave the core to whoever shares it, for some cycles. */
inline void pause()
{
#if defined(__x86_64__)
  _mm_pause();
#endif
}

/** An allocator whose arrays begin with a line of memory: threads then know which numbers share one. */
template <class T> struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <class Other> LineAllocator(const LineAllocator<Other> &) {}
  T *allocate(size_t n) { return static_cast<T *>(::operator new(n * sizeof(T), std::align_val_t(64))); }
  void deallocate(T *at, size_t) { ::operator delete(at, std::align_val_t(64)); }
  friend bool operator==(const LineAllocator &, const LineAllocator &) { return true; }
  friend bool operator!=(const LineAllocator &, const LineAllocator &) { return false; }
};

#ifdef JUMP_ONE_THREAD

/** The calling thread alone. */
class CallingThread {
 public:
  void resize(int) {}
  int size() const { return 1; }
  template <class Run> void run(int parts, const Run &run)
  {
    for (int part = 0; part < parts; part++) run(part);
  }
};
using ThreadPool = CallingThread;

#else

class ThreadPool {
 public:
  ThreadPool() = default;
  ~ThreadPool();

  /** Threads that take part from now on, the caller among them; helpers are made when they are first needed. */
  void resize(int threads);
  int size() const { return threads; }

  /** Call run(part) once for each part from 0 to `parts`, at most MOST_THREADS; returns when all have ended. */
  template <class Run> void run(int parts, const Run &run)
  {
    if (threads == 1 || parts == 1) {
      for (int part = 0; part < parts; part++) run(part);
      return;
    }
    share(parts, [](const void *run, int part) { (*static_cast<const Run *>(run))(part); }, &run);
  }

 private:
  using Call = void (*)(const void *, int);
  struct alignas(64) PartTaken {
    std::atomic<bool> taken{false};
  };

  int threads = 1;
  std::vector<std::thread> helpers;
  // the job, in one line of memory; written while nobody is inside
  alignas(64) std::atomic<uint64_t> job{0};    // its number
  std::atomic<bool> open{false};
  int parts = 0;
  Call call = nullptr;
  const void *context = nullptr;
  PartTaken marks[MOST_THREADS];
  alignas(64) std::atomic<int> active{0};      // helpers that may touch the job
  alignas(64) std::atomic<int> wanted{1};      // threads that take part
  std::atomic<int> asleep{0};
  std::atomic<bool> quits{false};
  std::mutex mutex;
  std::condition_variable wake;

  void share(int, Call, const void *);
  void take_parts(int);
  void help(int);
  void wake_helpers();
};

inline ThreadPool::~ThreadPool()
{
  quits = true;
  wake_helpers();
  for (auto &helper : helpers) helper.join();
}

inline void ThreadPool::wake_helpers()
{
  { const std::lock_guard<std::mutex> lock(mutex); }
  wake.notify_all();
}

inline void ThreadPool::resize(int count)
{
  threads = std::clamp(count, 1, MOST_THREADS);
  wanted = threads_now = threads;
  while ((int) helpers.size() < threads - 1) helpers.emplace_back(&ThreadPool::help, this, (int) helpers.size() + 1);
}

inline void ThreadPool::take_parts(int own)
{
  const int first = own * parts / threads;
  for (int n = 0; n < parts; n++) {
    const int part = (first + n) % parts;
    auto &taken = marks[part].taken;
    if (!taken.load(std::memory_order_relaxed) && !taken.exchange(true)) call(context, part);
  }
}

inline void ThreadPool::share(int count, Call what, const void *with)
{
  call = what;
  context = with;
  parts = count;
  for (int part = 0; part < parts; part++) marks[part].taken.store(false, std::memory_order_relaxed);
  open = true;
  job++;
  if (asleep > (int) helpers.size() - (threads - 1)) wake_helpers();    // those that take no part sleep on
  take_parts(0);
  open = false;    // who comes now finds nothing; who is inside ends its part
  auto since = WallClock::time_point();
  for (int look = 1; active > 0; look++) {
    pause();
    if (look % LOOKS != 0) continue;
    const auto now = WallClock::now();
    if (since == WallClock::time_point()) since = now;
    else if (now - since > PATIENCE) std::this_thread::yield();
  }
}

inline void ThreadPool::help(int own)
{
  uint64_t seen = 0;
  const auto called = [&]() { return quits || (job != seen && own < wanted); };
  while (true) {
    auto since = WallClock::time_point();
    for (int look = 1; !called(); look++) {
      pause();
      if (look % LOOKS != 0) continue;
      const auto now = WallClock::now();
      if (since == WallClock::time_point()) since = now;
      else if (now - since > PATIENCE && now - since <= AWAKE && own < wanted) std::this_thread::yield();
      else if (now - since > AWAKE || own >= wanted) {
        std::unique_lock<std::mutex> lock(mutex);
        asleep++;
        wake.wait(lock, called);
        asleep--;
        break;
      }
    }
    if (quits) return;
    seen = job;
    __builtin_prefetch(&marks[own], 1);    // comes while the next one is waited for
    active++;
    if (open) take_parts(own);
    active--;
  }
}

#endif

/** How many threads a run takes: the number given, or what recent steps have shown to be the quickest. */
class ThreadTuner {
 public:
  /** Words as of the variable LAMMPS_JUMP_THREADS: a number, or auto:MOST. */
  void read(const char *words);
  int threads() const { return probing ? probed : level; }

  void begin_step(int discs);
  /** A step has ended; `odd` ones (a list was made) are no measure of a step. */
  void end_step(bool odd);

 private:
  static constexpr int WINDOW = 40, FIRST_REST = 10, LONGEST_REST = 1280, FEW_DISCS = 300;
  static constexpr double COLD = 8.0;    // steps that it may cost at first until discs are in the caches of other threads

  bool fixed = true, probing = false;
  int most = 1, level = 1, probed = 1;
  int steps = 0, rest = FIRST_REST, until_probe = 1;    // windows
  bool up = true;
  double spent = 0.0, cost = 0.0, usual = 0.0;          // s; s a step of late, and in the long run
  double discs = 0.0;
  WallClock::time_point begun;

  void end_window();
  void start_probe();
};

inline void ThreadTuner::read(const char *words)
{
  fixed = true;
  level = most = 1;
  if (!words) return;
  fixed = std::strncmp(words, "auto:", 5) != 0;
  most = std::clamp(std::atoi(fixed ? words : words + 5), 1, MOST_THREADS);
  level = fixed ? most : 1;
  fixed |= most == 1;
}

inline void ThreadTuner::begin_step(int count)
{
  if (fixed) return;
  discs = count;
  begun = WallClock::now();
}

inline void ThreadTuner::end_step(bool odd)
{
  if (fixed || odd || discs < FEW_DISCS) return;
  const double seconds = std::chrono::duration<double>(WallClock::now() - begun).count() / discs;
  spent += seconds;
  steps++;
  const bool is_slower = probing && spent > (1.2 * steps + COLD) * cost;    // no need to see the rest of it
  if (steps == WINDOW || is_slower) end_window();
}

/** Whether so many threads have cores of their own now, besides what else runs; true where the system does not say. */
inline bool have_cores(int threads, int now)
{
#ifdef JUMP_ONE_THREAD
  return threads <= now;
#else
  int running = 0;
  FILE *const file = fopen("/proc/loadavg", "r");
  const bool told = file && fscanf(file, "%*f %*f %*f %d/", &running) == 1;
  if (file) fclose(file);
  return !told || running - now + threads <= (int) std::thread::hardware_concurrency();
#endif
}
/** Levels are 1, 2, 4, ... and the most: the neighbours of the one in use are tried in turn. */
inline void ThreadTuner::start_probe()
{
  if (level == 1) up = true;
  else if (level == most) up = false;
  probed = up ? std::min(2 * level, most) : level == most && (most & (most - 1)) ? 1 << (31 - __builtin_clz(most)) : level / 2;
  if (probed > level && !have_cores(probed, level)) {    // a helper that waits for a core would hold up all
    until_probe = rest;
    return;
  }
  up = !up;
  probing = true;
}

inline void ThreadTuner::end_window()
{
  const double found = spent / steps;
  spent = 0.0;
  steps = 0;
  if (probing) {
    probing = false;
    const bool better = found < (probed > level ? 0.97 : 1.0) * cost;
    if (better) {
      level = probed;
      cost = usual = found;
      up = probed > 1;
    }
    rest = better ? FIRST_REST : std::min(2 * rest, LONGEST_REST);
    until_probe = rest;
    return;
  }
  cost = cost > 0.0 ? 0.5 * (cost + found) : found;
  usual = usual > 0.0 ? 0.95 * usual + 0.05 * found : found;
  if (level > 1 && found > 1.3 * usual) {    // other work has come: is one fewer better?
    up = false;
    rest = FIRST_REST;
    until_probe = 0;
  }
  if (until_probe-- <= 0) start_probe();
}

}    // namespace jump

#endif
