// SPDX-License-Identifier: GPL-2.0-or-later
/* Contacts of a frame with their forces, as lammps_jump/dump/contacts.py reads them. */

#ifndef JUMP_RECORD_H
#define JUMP_RECORD_H

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace jump {

/** Id of the disc that the force acts on, that of the other or -1 - w of a wall; point, force, power (not known here). */
struct ContactRow {
  int32_t one, other;
  float x, y, fx, fy, power;
};

/** Whether the rows of a step have been put into a file; the first step begins it anew. */
inline bool put_rows(const std::string &name, int64_t step, const std::vector<ContactRow> &rows)
{
  static_assert(sizeof(ContactRow) == 28, "rows are read in 28 bytes");
  FILE *const file = std::fopen(name.c_str(), step == 0 ? "wb" : "ab");
  if (!file) return false;
  char head[20] = {'L', 'J', 'C', '1'};
  const int64_t count = (int64_t) rows.size();
  std::memcpy(head + 4, &step, 8);
  std::memcpy(head + 12, &count, 8);
  bool done = std::fwrite(head, 1, sizeof head, file) == sizeof head;
  done = done && std::fwrite(rows.data(), sizeof(ContactRow), rows.size(), file) == rows.size();
  return !std::fclose(file) && done;
}

}    // namespace jump

#endif
