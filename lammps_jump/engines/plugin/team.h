// SPDX-License-Identifier: GPL-2.0-or-later
/* Threads that share the parts of a loop, and how many of them a run takes.

   The calling thread and its helpers take parts until none is left. Each begins with a share of its own, so that data
   stay in its cache, and goes on with parts that nobody has begun: a helper that the system does not run holds nobody
   up. Which thread does a part never changes a result: a part writes only what is its own. */

#ifndef JUMP_TEAM_H
#define JUMP_TEAM_H

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

namespace jump {

constexpr int MOST_THREADS = 64;
extern std::atomic<int> threads_now;    // of the run of this process, for who looks on

/** An allocator whose arrays begin with a line of memory: threads then know which numbers share one. */
template <class T> struct Lines {
  using value_type = T;
  Lines() = default;
  template <class Other> Lines(const Lines<Other> &) {}
  T *allocate(size_t n) { return static_cast<T *>(::operator new(n * sizeof(T), std::align_val_t(64))); }
  void deallocate(T *at, size_t) { ::operator delete(at, std::align_val_t(64)); }
  friend bool operator==(const Lines &, const Lines &) { return true; }
  friend bool operator!=(const Lines &, const Lines &) { return false; }
};

class Team {
 public:
  Team() = default;
  ~Team();

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
  struct alignas(64) Mark {
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
  Mark marks[MOST_THREADS];
  alignas(64) std::atomic<int> inside{0};      // helpers that may touch the job
  alignas(64) std::atomic<int> wanted{1};      // threads that take part
  std::atomic<int> asleep{0};
  std::atomic<bool> quits{false};
  std::mutex door;
  std::condition_variable bell;

  void share(int, Call, const void *);
  void take_parts(int);
  void help(int);
  void wake();
};

/** How many threads a run takes: the number asked for, or what steps of late have shown to be the quickest. */
class Pace {
 public:
  /** Words as of the variable LAMMPS_JUMP_THREADS: a number, or auto:MOST. */
  void read(const char *words);
  int threads() const { return probing ? probed : level; }

  void begin_step(int discs);
  /** A step has ended; `odd` ones (a list was made) are no measure of a step. */
  void end_step(bool odd);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int WINDOW = 40, FIRST_REST = 10, LONGEST_REST = 1280, FEW_DISCS = 300;

  bool fixed = true, probing = false;
  int most = 1, level = 1, probed = 1;
  int steps = 0, rest = FIRST_REST, until_probe = 1;    // windows
  bool up = true;
  double spent = 0.0, cost = 0.0, usual = 0.0;          // s; s a step of late, and in the long run
  double discs = 0.0;
  Clock::time_point begun;

  void end_window();
  void start_probe();
};

}    // namespace jump

#endif
