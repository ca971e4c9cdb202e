// SPDX-License-Identifier: GPL-2.0-or-later
/* A scene as an image of memory, which a host reads (engines/native/image.py writes it). */

#ifndef JUMP_CORE_IMAGE_H
#define JUMP_CORE_IMAGE_H

#include "step/events.h"

#include <cstring>
#include <vector>

namespace jump {

/** State and events of a scene; their pointers lead into the image. */
class SceneImage {
 public:
  jump_state *state = nullptr;
  jump_events *events = nullptr;

  SceneImage() = default;
  SceneImage(const SceneImage &) = delete;
  SceneImage &operator=(const SceneImage &) = delete;

  /** Take the bytes of a file; false where they are none of this version of the core. */
  bool take(const std::vector<char> &file)
  {
    Head head;
    if (file.size() < sizeof head) return false;
    std::memcpy(&head, file.data(), sizeof head);
    const int64_t most = (int64_t) file.size(), word = (int64_t) sizeof(void *);
    if (head.magic != MAGIC || head.word != word || head.size < 0 || head.size > most) return false;
    if (head.pointers < 0 || head.pointers > most / word) return false;
    const size_t places = sizeof(int64_t) * (size_t) head.pointers;
    if (file.size() != sizeof head + places + (size_t) head.size + sizeof(Tail)) return false;
    Tail tail;
    std::memcpy(&tail, file.data() + file.size() - sizeof tail, sizeof tail);
    if (tail.version != VERSION || tail.state != sizeof(jump_state) || tail.events != sizeof(jump_events)) return false;
    memory.resize((size_t) head.size / sizeof(double) + 1);
    char *const base = reinterpret_cast<char *>(memory.data());
    std::memcpy(base, file.data() + sizeof head + places, (size_t) head.size);
    for (int64_t p = 0; p < head.pointers; p++) {
      int64_t place;
      uintptr_t there;
      std::memcpy(&place, file.data() + sizeof head + sizeof place * (size_t) p, sizeof place);
      if (!holds(head, place, word)) return false;
      std::memcpy(&there, base + place, sizeof there);
      if (there > (uintptr_t) head.size) return false;
      there += reinterpret_cast<uintptr_t>(base);
      std::memcpy(base + place, &there, sizeof there);
    }
    if (!holds(head, head.state, sizeof(jump_state)) || !holds(head, head.events, sizeof(jump_events))) return false;
    state = reinterpret_cast<jump_state *>(base + head.state);
    events = reinterpret_cast<jump_events *>(base + head.events);
    return true;
  }

 private:
  struct Head {
    int64_t magic, word, size, pointers, state, events;
  };
  struct Tail {
    int64_t version, state, events;
  };
  /** Tells whether so many bytes from a place on lie in the image, where a number may be. */
  static bool holds(const Head &head, int64_t place, int64_t bytes)
  {
    return place >= 0 && place % (int64_t) sizeof(void *) == 0 && bytes <= head.size && place <= head.size - bytes;
  }
  static constexpr int64_t MAGIC = 0x31474D494D4C4A;
  std::vector<double> memory;
};

}    // namespace jump

#endif
