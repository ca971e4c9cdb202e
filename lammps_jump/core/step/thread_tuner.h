// SPDX-License-Identifier: GPL-2.0-or-later
/* How many threads a run takes. */

#ifndef JUMP_CORE_THREAD_TUNER_H
#define JUMP_CORE_THREAD_TUNER_H

#include "step/thread_pool.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace jump {

/** How many threads a run takes: the number asked for, or what steps of late have shown to be the quickest. */
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
  const double took = std::chrono::duration<double>(WallClock::now() - begun).count() / discs;
  spent += took;
  steps++;
  const bool lost = probing && spent > (1.2 * steps + COLD) * cost;    // no need to see the rest of it
  if (steps == WINDOW || lost) end_window();
}

/** Whether so many threads have cores of their own now, beside what else runs; true where the system does not tell. */
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
