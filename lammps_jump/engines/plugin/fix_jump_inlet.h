// SPDX-License-Identifier: GPL-2.0-or-later
/* fix ID all jump/inlet DIAMETER MASS [turns FILE] [row FIRST EVERY MOST NEAR X Y VX VY]...

   Rows of discs that flow in, as `fix deposit` with a region of one point gives them, each row by one fix of its own. At
   the steps FIRST + i EVERY a row lets a disc in at (X, Y) with the velocity (VX, VY), unless a centre lies closer
   than NEAR, or MOST discs have come by this row (0: any number). Rows of the same step come in their order. A disc gets
   the id above the highest one. The discs of a restart file count.

   A row whose EVERY is 0 lets discs in at the steps that FILE names, with the VX given there: an inflow against
   time. A line of FILE is the number of the row, from 1, the step, and VX. The steps of a row rise.

   `fix deposit` allocates memory for each disc that it compares (the name of its source file, for
   Domain::minimum_image), in each of its rows: 7 % of the time of a jet. */

#ifndef LMP_FIX_JUMP_INLET_H
#define LMP_FIX_JUMP_INLET_H

#include "fix.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class FixJumpInlet : public Fix {
 public:
  FixJumpInlet(class LAMMPS *, int, char **);
  int setmask() override;
  void setup_pre_exchange() override;
  void pre_exchange() override;
  void write_restart(FILE *) override;
  void restart(char *) override;

 private:
  struct EntryRow {
    bigint first, every, most, come;
    double near, x, y, vx, vy;
    std::vector<bigint> steps = {};    // with EVERY 0
    std::vector<double> speeds = {};

    bigint next_after(bigint step) const;    // 0 where none comes
    bool is_full() const { return most > 0 && come >= most; }
    double speed_at(bigint step) const;
  };

  double diameter, mass;
  std::vector<EntryRow> rows;

  void read_turns(const std::string &);
  void find_next();
  bool is_free(const EntryRow &) const;
  bool insert(const EntryRow &, tagint);
};

}    // namespace LAMMPS_NS

#endif
