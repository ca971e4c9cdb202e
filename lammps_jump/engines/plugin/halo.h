// SPDX-License-Identifier: GPL-2.0-or-later
/* The discs of other ranks near this one's part of the channel, for pair_style jump/disc on several ranks, and images
   across the seam of a periodic channel: a rank sends them to itself, too.

   Takes the place of LAMMPS' ghosts where space is cut along x alone. A disc is five numbers (one more each with spin
   and with sizes) instead of nine, all messages of a step leave together, and they travel while the contacts among the
   rank's own discs are computed. Who is sent is chosen anew when LAMMPS reneighbours; discs further away than the cut
   cannot come into touch before. */

#ifndef JUMP_HALO_H
#define JUMP_HALO_H

#include "pointers.h"

#include <cstdint>
#include <mpi.h>
#include <vector>

namespace LAMMPS_NS {

class PairJumpDisc;

class JumpHalo : protected Pointers {
 public:
  JumpHalo(LAMMPS *lmp) : Pointers(lmp) {}

  void rebuild(PairJumpDisc &pair, double cut);
  void renumber(const std::vector<uint64_t> &sorted);
  void start(PairJumpDisc &pair);
  void finish(PairJumpDisc &pair);

  bool is_needed() const;
  int count() const { return number; }

 private:
  /** A rank with discs in reach. */
  struct Partner {
    int rank;
    int incoming = 0;             // discs it sends
    std::vector<int> mine;        // local discs that it gets
    std::vector<double> shift;    // what each of them gets added to x, m
    std::vector<double> out, in;
  };

  std::vector<Partner> partners;
  std::vector<MPI_Request> requests;
  int number = 0;

  double cut_at(int index) const;
};

}    // namespace LAMMPS_NS

#endif
