// SPDX-License-Identifier: GPL-2.0-or-later
#include "halo.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"

#include <algorithm>

using namespace LAMMPS_NS;

namespace {
constexpr int MOST_LOOKS = 1000;    // before waiting in earnest, which lets others have the core and is slower to answer
constexpr int DISCS = 7402;    // tag that LAMMPS does not use

/** Numbers that stand for a disc in a message. */
int words_of(const PairJumpDisc &pair)
{
  return 4 + pair.spin + pair.sizes * (1 + pair.any_fixed()) + pair.springs;
}
}

/** Whether there are any discs but the local ones. */
bool JumpHalo::is_needed() const
{
  return comm->nprocs > 1 || domain->xperiodic;
}

/** Where the cut with this number lies; what is beyond open ends belongs to the ranks at the ends. */
double JumpHalo::cut_at(int index) const
{
  if (!domain->xperiodic) {
    if (index <= 0) return -1e300;
    if (index >= comm->procgrid[0]) return 1e300;
  }
  return domain->boxlo[0] + comm->xsplit[index] * domain->prd[0];
}

/** Choose whom to send what, and exchange it: discs closer than cut to the part of another rank. */
void JumpHalo::rebuild(PairJumpDisc &pair, double cut)
{
  const int here = comm->myloc[0], ranks = comm->nprocs;
  std::vector<int> outgoing(ranks, 0), incoming(ranks);
  partners.clear();
  for (int there = 0; there < ranks; there++) {
    const double lo = cut_at(there) - cut, hi = cut_at(there + 1) + cut;
    Partner partner;
    partner.rank = comm->grid2proc[there][0][0];
    for (int turn = domain->xperiodic ? -1 : 0; turn <= domain->xperiodic; turn++) {
      if (there == here && turn == 0) continue;
      const double shift = turn * domain->prd[0];
      for (int i = 0; i < atom->nlocal; i++)
        if (pair.disc[i].x + shift > lo && pair.disc[i].x + shift < hi) {
          partner.mine.push_back(i);
          partner.shift.push_back(shift);
        }
    }
    outgoing[partner.rank] = (int) partner.mine.size();
    partners.push_back(std::move(partner));
  }
  MPI_Alltoall(outgoing.data(), 1, MPI_INT, incoming.data(), 1, MPI_INT, world);
  number = 0;
  for (auto &partner : partners) number += partner.incoming = incoming[partner.rank];
  pair.reserve(atom->nlocal + number);
  start(pair);
  finish(pair);
}

/** Send what the others need of this step's positions and velocities, and ask for theirs. */
void JumpHalo::start(const PairJumpDisc &pair)
{
  const int words = words_of(pair);
  requests.clear();
  for (auto &partner : partners) {
    if (partner.incoming > 0) {
      partner.in.resize((size_t) words * partner.incoming);
      requests.emplace_back();
      MPI_Irecv(partner.in.data(), (int) partner.in.size(), MPI_DOUBLE, partner.rank, DISCS, world, &requests.back());
    }
    if (partner.mine.empty()) continue;
    partner.out.resize((size_t) words * partner.mine.size());
    double *to = partner.out.data();
    for (size_t m = 0; m < partner.mine.size(); m++) {
      const int i = partner.mine[m];
      const auto &disc = pair.disc[i];
      to[0] = disc.x + partner.shift[m];
      to[1] = disc.y;
      to[2] = disc.vx;
      to[3] = disc.vy;
      if (pair.spin) to[4] = pair.spins[i];
      if (pair.sizes) to[words - 1] = pair.radii[i];
      if (pair.any_fixed()) to[words - 2] = (double) pair.stays[i];
      if (pair.springs) to[4 + pair.spin] = (double) pair.ids[i];
      to += words;
    }
    requests.emplace_back();
    MPI_Isend(partner.out.data(), (int) partner.out.size(), MPI_DOUBLE, partner.rank, DISCS, world, &requests.back());
  }
}

/** Wait for the others' discs; they stand behind the local ones. */
void JumpHalo::finish(PairJumpDisc &pair)
{
  int all = 0;
  for (int look = 0; look < MOST_LOOKS && !all; look++)
    MPI_Testall((int) requests.size(), requests.data(), &all, MPI_STATUSES_IGNORE);
  if (!all) MPI_Waitall((int) requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  const int words = words_of(pair);
  int i = atom->nlocal;
  for (const auto &partner : partners) {
    const double *from = partner.in.data();
    for (int n = 0; n < partner.incoming; n++, i++, from += words) {
      pair.disc[i] = {from[0], from[1], from[2], from[3]};
      if (pair.spin) pair.spins[i] = from[4];
      if (pair.springs) pair.ids[i] = (int64_t) from[4 + pair.spin];
      if (pair.any_fixed()) pair.stays[i] = (int64_t) from[words - 2];
      if (pair.sizes) pair.radii[i] = from[words - 1];    // each step: inserted discs change theirs
    }
  }
}
