// SPDX-License-Identifier: GPL-2.0-or-later
/* A host of the core without Python: reads an image of a scene, steps it, writes where its discs are.

   host IMAGE STEP OUT; see engines/native/image.py for the file. The exit status is that of `jump_run`, or 9. */

#include "step/events.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

struct Head {
  int64_t magic, word, size, pointers, state, events;
};

template <class T> bool read(std::FILE *file, T *to, size_t count) { return std::fread(to, sizeof(T), count, file) == count; }

/** The image in memory, its pointers moved to where it is; empty where the file is none. */
std::vector<int64_t> load(const char *path, Head &head)
{
  std::vector<int64_t> image;
  std::FILE *file = std::fopen(path, "rb");
  if (!file) return image;
  if (read(file, &head, 1) && head.magic == 0x31474D494D4C4A && head.word == (int64_t) sizeof(void *)) {
    std::vector<int64_t> places((size_t) head.pointers);
    image.resize((size_t) head.size / 8 + 1);
    char *const base = reinterpret_cast<char *>(image.data());
    if (!read(file, places.data(), places.size()) || !read(file, base, (size_t) head.size)) image.clear();
    if (!image.empty())
      for (const int64_t place : places) {
        uintptr_t there;
        std::memcpy(&there, base + place, sizeof there);
        there += reinterpret_cast<uintptr_t>(base);
        std::memcpy(base + place, &there, sizeof there);
      }
  }
  std::fclose(file);
  return image;
}

}    // namespace

int main(int count, char **words)
{
  if (count != 4) return 9;
  Head head;
  std::vector<int64_t> image = load(words[1], head);
  if (image.empty()) return 9;
  char *const base = reinterpret_cast<char *>(image.data());
  jump_state *const state = reinterpret_cast<jump_state *>(base + head.state);
  jump_events *const events = reinterpret_cast<jump_events *>(base + head.events);
  jump::ThreadPartition *const threads = jump_partition("1");
  const int64_t end = jump_run(state, events, threads, std::atoll(words[2]));
  std::FILE *const file = std::fopen(words[3], "wb");
  if (!file) return 9;
  const int64_t told[2] = {events->step, state->n};
  std::fwrite(told, sizeof told, 1, file);
  std::fwrite(state->ids, 8, (size_t) state->n, file);
  for (const double *const column : {state->x, state->y, state->vx, state->vy, state->fx, state->fy, state->omega})
    if (column) std::fwrite(column, 8, (size_t) state->n, file);
  std::fwrite(state->wall_sum, sizeof(jump::SumsOnWall), (size_t) state->walls, file);
  std::fclose(file);
  jump_free_partition(threads);
  return (int) end;
}
