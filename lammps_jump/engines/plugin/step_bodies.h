// SPDX-License-Identifier: GPL-2.0-or-later
/* Bodies of fix jump/step: the walls of the fix as the core takes them, with their corners and what these remember.

   Every rank holds all of it and does the same: contacts of bodies follow from the poses of walls, which all ranks have. */

#ifndef JUMP_STEP_BODIES_H
#define JUMP_STEP_BODIES_H

#include "walls/bodies.h"
#include "near_faces.h"

#include <array>
#include <string>
#include <vector>

namespace jump {

struct StepBodies {
  static constexpr int SLOTS = 8;    // contacts that a corner remembers

  bool there = false;
  std::vector<Corner> corners;
  std::vector<double> own_radius;    // of corners, as told
  std::vector<BodyLaw> between;      // by the walls of a corner and of a face; stiffness 0: they do not meet
  std::vector<NearFaces> near;       // of each wall, with corners in the place of discs
  double limit = 0.0;                // largest overlap, m
  double damping_ratio = 0.0;        // tangential dashpot over the normal one, of springs
  int every = 0;                     // steps between rows of the file
  std::string file;
  double start = 0.0;                // step of t = 0

  // of walls
  std::vector<Face> faces;
  std::vector<int64_t> first, deep, moving, chain;
  std::vector<double> around;
  std::vector<std::array<double, 2>> about, centre;
  std::vector<Placed> placed;
  std::vector<Load> load;
  std::vector<Pushed> pushed;
  std::vector<WallLoads> taken;
  std::vector<SumsOnWall> sums;
  std::vector<Sum> window;    // force of discs on each wall since the last row
  int64_t window_steps = 0;

  // of corners
  std::vector<int64_t> ids, partner;
  std::vector<double> sigma, spring, roll;
  std::vector<int8_t> used, plain;
  std::vector<int64_t> near_rows, near_last, near_faces;
  std::vector<int32_t> near_discs;
  int64_t full = 0;
  double deepest[3] = {};

  jump_state of_corners{}, of_walls{};

  /** Room for what corners remember. */
  void make_slots()
  {
    const size_t slots = corners.size() * SLOTS;
    ids.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++) ids[i] = (int64_t) i + 1;
    partner.assign(slots, 0);
    for (auto *const of : {&sigma, &spring, &roll}) of->assign(slots, 0.0);
    used.assign(slots, 0);
  }

  /** Empty the slots whose contacts have ended. */
  void end_contacts()
  {
    for (size_t at = 0; at < used.size(); at++) {
      if (used[at] == 0) {
        partner[at] = 0;
        sigma[at] = spring[at] = roll[at] = 0.0;
      }
      used[at] = 0;
    }
  }

  /** Put the lists of all walls one behind the other. */
  void join_lists()
  {
    near_rows.assign(1, 0);
    near_last.assign(1, 0);
    near_discs.clear();
    near_faces.clear();
    for (size_t wall = 0; wall < near.size(); wall++) {
      const NearFaces &own = near[wall];
      for (size_t row = 0; row < own.discs.size(); row++) {
        near_discs.push_back(own.discs[row]);
        for (int at = own.last[row]; at < own.last[row + 1]; at++) near_faces.push_back(first[wall] + own.near[at]);
        near_last.push_back((int64_t) near_faces.size());
      }
      near_rows.push_back((int64_t) near_discs.size());
    }
    plain.assign(near_discs.size() + 1, 0);
  }

  /** Tell the core where all of it is. */
  void bind()
  {
    jump_state &c = of_corners, &s = of_walls;
    c = s = {};
    c.n = (int64_t) corners.size();
    c.ids = ids.data();
    c.slots = SLOTS;
    c.partner = partner.data(), c.sigma = sigma.data(), c.spring = spring.data(), c.roll = roll.data(), c.used = used.data();
    c.full = &full;
    c.chain = chain.data(), c.around = around.data();
    c.near_rows = near_rows.data(), c.near_discs = near_discs.data(), c.near_plain = plain.data();
    c.near_last = near_last.data(), c.near_faces = near_faces.data();
    c.walls = s.walls = (int64_t) deep.size();
    c.faces = s.faces = faces.data();
    c.deep = s.deep = deep.data();
    s.about = reinterpret_cast<const double(*)[2]>(about.data());
    s.centre = reinterpret_cast<const double(*)[2]>(centre.data());
    s.wall_sum = sums.data();
    s.moving = moving.data();
    s.placed = placed.data(), s.load = load.data(), s.pushed = pushed.data(), s.taken = taken.data();
    s.corners = &of_corners;
    s.corner = corners.data();
    s.between = between.data();
    s.deepest = deepest;
  }
};

}    // namespace jump

#endif
