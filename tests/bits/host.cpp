// SPDX-License-Identifier: GPL-2.0-or-later
/* A host of the core without Python: reads an image of a scene, steps it, writes where its discs are.

   host IMAGE STEP OUT; see engines/native/image.py for the file. The exit status is that of `jump_run`, or 9. */

#include "step/image.h"

#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

std::vector<char> bytes_of(const char *path)
{
  std::vector<char> bytes;
  char part[4096];
  std::FILE *const file = std::fopen(path, "rb");
  if (!file) return bytes;
  while (const size_t count = std::fread(part, 1, sizeof part, file)) bytes.insert(bytes.end(), part, part + count);
  std::fclose(file);
  return bytes;
}

}    // namespace

int main(int count, char **words)
{
  if (count != 4) return 9;
  jump::SceneImage image;
  if (!image.take(bytes_of(words[1]))) return 9;
  jump_state *const state = image.state;
  jump_events *const events = image.events;
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
