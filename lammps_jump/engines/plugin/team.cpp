// SPDX-License-Identifier: GPL-2.0-or-later
/* Threads that share the parts of a loop (what they are: team.h). */

#include "team.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

using namespace jump;

namespace {
using Clock = std::chrono::steady_clock;
constexpr auto AWAKE = std::chrono::microseconds(60);     // a helper waits so long for a job before it sleeps
constexpr auto PATIENCE = std::chrono::microseconds(20);  // the caller waits so long before it offers its core
constexpr int LOOKS = 32;                                 // between two looks at the clock

inline void pause()
{
#if defined(__x86_64__)
  _mm_pause();
#endif
}
}    // namespace

std::atomic<int> jump::threads_now{1};

Team::~Team()
{
  quits = true;
  wake();
  for (auto &helper : helpers) helper.join();
}

void Team::wake()
{
  { const std::lock_guard<std::mutex> lock(door); }
  bell.notify_all();
}

void Team::resize(int count)
{
  threads = std::clamp(count, 1, MOST_THREADS);
  wanted = threads_now = threads;
  while ((int) helpers.size() < threads - 1) helpers.emplace_back(&Team::help, this, (int) helpers.size() + 1);
}

void Team::take_parts(int own)
{
  const int first = own * parts / threads;
  for (int n = 0; n < parts; n++) {
    const int part = (first + n) % parts;
    auto &taken = marks[part].taken;
    if (!taken.load(std::memory_order_relaxed) && !taken.exchange(true)) call(context, part);
  }
}

void Team::share(int count, Call what, const void *with)
{
  call = what;
  context = with;
  parts = count;
  for (int part = 0; part < parts; part++) marks[part].taken.store(false, std::memory_order_relaxed);
  open = true;
  job++;
  if (asleep > (int) helpers.size() - (threads - 1)) wake();    // those that take no part sleep on
  take_parts(0);
  open = false;    // who comes now finds nothing; who is inside ends its part
  auto since = Clock::time_point();
  for (int look = 1; inside > 0; look++) {
    pause();
    if (look % LOOKS != 0) continue;
    const auto now = Clock::now();
    if (since == Clock::time_point()) since = now;
    else if (now - since > PATIENCE) std::this_thread::yield();
  }
}

void Team::help(int own)
{
  uint64_t seen = 0;
  const auto called = [&]() { return quits || (job != seen && own < wanted); };
  while (true) {
    auto since = Clock::time_point();
    for (int look = 1; !called(); look++) {
      pause();
      if (look % LOOKS != 0) continue;
      const auto now = Clock::now();
      if (since == Clock::time_point()) since = now;
      else if (now - since > AWAKE || own >= wanted) {
        std::unique_lock<std::mutex> lock(door);
        asleep++;
        bell.wait(lock, called);
        asleep--;
        break;
      }
    }
    if (quits) return;
    seen = job;
    __builtin_prefetch(&marks[own], 1);    // comes while the next one is waited for
    inside++;
    if (open) take_parts(own);
    inside--;
  }
}

void Pace::read(const char *words)
{
  fixed = true;
  level = most = 1;
  if (!words) return;
  fixed = std::strncmp(words, "auto:", 5) != 0;
  most = std::clamp(std::atoi(fixed ? words : words + 5), 1, MOST_THREADS);
  level = fixed ? most : 1;
  fixed |= most == 1;
}

void Pace::begin_step(int count)
{
  if (fixed) return;
  discs = count;
  begun = Clock::now();
}

void Pace::end_step(bool odd)
{
  if (fixed || odd || discs < FEW_DISCS) return;
  const double took = std::chrono::duration<double>(Clock::now() - begun).count() / discs;
  spent += took;
  steps++;
  const bool lost = probing && spent > 1.5 * WINDOW * cost;    // no need to see the rest of it
  if (steps == WINDOW || lost) end_window();
}

namespace {
/** Whether so many threads have cores of their own now, beside what else runs; true where the system does not tell. */
bool have_cores(int threads, int now)
{
  int running = 0;
  FILE *const file = fopen("/proc/loadavg", "r");
  const bool told = file && fscanf(file, "%*f %*f %*f %d/", &running) == 1;
  if (file) fclose(file);
  return !told || running - now + threads <= (int) std::thread::hardware_concurrency();
}
}    // namespace

/** Levels are 1, 2, 4, ... and the most: the neighbours of the one in use are tried in turn. */
void Pace::start_probe()
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

void Pace::end_window()
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
