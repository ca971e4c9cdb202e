// SPDX-License-Identifier: GPL-2.0-or-later
/* fix ID all jump/inlet DIAMETER MASS [row FIRST EVERY MOST NEAR X Y VX VY]...

   Rows of discs that flow in, as `fix deposit` with a region of one point gives them, each row by one fix of its own. At
   the steps FIRST + i EVERY a row lets a disc in at (X, Y) with the velocity (VX, VY), unless a centre lies closer
   than NEAR, or MOST discs have come by this row (0: any number). Rows of the same step come in their order. A disc gets
   the id above the highest one. The discs of a restart file count.

   `fix deposit` allocates memory for each disc that it compares (the name of its source file, for
   Domain::minimum_image), in each of its rows: 7 % of the time of a jet. */

#ifndef LMP_FIX_JUMP_INLET_H
#define LMP_FIX_JUMP_INLET_H

#include "fix.h"

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

    bool is_due(bigint step) const { return step >= first && (step - first) % every == 0 && !is_full(); }
    bool is_full() const { return most > 0 && come >= most; }
  };

  double diameter, mass;
  std::vector<EntryRow> rows;

  void find_next();
  bool is_free(const EntryRow &) const;
  bool insert(const EntryRow &, tagint);
};

}    // namespace LAMMPS_NS

#endif
