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

/** Numbers that represent a disc in a message. */
int words_of(const PairJumpDisc &pair)
{
  const jump_state &s = pair.state();
  return 5 + (s.omega != nullptr) + (s.radius != nullptr) + (s.fixed != nullptr);
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
        if (pair.rows()[i][0] + shift > lo && pair.rows()[i][0] + shift < hi) {
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
  pair.reserve(2 * (int64_t) atom->nlocal + number);    // discs near the cuts have two rows of the list
  pair.partition.make_room_for(pair.state().n, number);
  start(pair);
  finish(pair);
}

/** The core has sorted the local discs: that with the number k had another before. */
void JumpHalo::renumber(const std::vector<uint64_t> &sorted)
{
  std::vector<int> now(sorted.size());
  for (size_t k = 0; k < sorted.size(); k++) now[jump::was_at(sorted[k])] = (int) k;
  for (auto &partner : partners)
    for (int &i : partner.mine) i = now[i];
}

/** Send what the others need of this step's positions and velocities, and ask for theirs. */
void JumpHalo::start(PairJumpDisc &pair)
{
  const jump_state &s = pair.state();
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
      double *next = std::copy_n(pair.rows()[i], 4, to);
      *to += partner.shift[m];
      *next++ = (double) s.ids[i];
      if (s.omega) *next++ = s.omega[i];
      if (s.radius) *next++ = s.radius[i];    // each step: inserted discs change theirs
      if (s.fixed) *next++ = (double) s.fixed[i];
      to += words;
    }
    requests.emplace_back();
    MPI_Isend(partner.out.data(), (int) partner.out.size(), MPI_DOUBLE, partner.rank, DISCS, world, &requests.back());
  }
}

/** Wait for the others' discs; they come after the local ones. */
void JumpHalo::finish(PairJumpDisc &pair)
{
  int all = 0;
  for (int look = 0; look < MOST_LOOKS && !all; look++)
    MPI_Testall((int) requests.size(), requests.data(), &all, MPI_STATUSES_IGNORE);
  if (!all) MPI_Waitall((int) requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  const int words = words_of(pair);
  const jump_state &s = pair.state();
  int64_t i = s.n;
  for (const auto &partner : partners) {
    const double *from = partner.in.data();
    for (int n = 0; n < partner.incoming; n++, i++, from += words) {
      const double *next = from + 4;
      std::copy(from, next, pair.rows()[i]);
      s.ids[i] = (int64_t) *next++;
      if (s.omega) s.omega[i] = *next++;
      if (s.radius) s.radius[i] = *next++;
      if (s.fixed) s.fixed[i] = (int64_t) *next++;
    }
  }
}
