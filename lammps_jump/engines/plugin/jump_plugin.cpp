// SPDX-License-Identifier: GPL-2.0-or-later
/* Registers pair_style jump/disc, fix jump/step and fix jump/inlet with LAMMPS (`plugin load`).

   The structure is the interface that LAMMPS' plugin command documents (developer guide, "Writing plugins"); the
   wheel ships no header for it. Everything else is hidden (-fvisibility=hidden): two builds of the plugin in one
   process must not take each other's code. */

#include "fix_jump_inlet.h"
#include "fix_jump_step.h"
#include "lammps.h"
#include "pair_jump_disc.h"

using namespace LAMMPS_NS;

namespace {

struct Registration {
  const char *version;
  const char *style;
  const char *name;
  const char *info;
  const char *author;
  union {
    void *(*plain)(void *);
    void *(*with_arguments)(void *, int, char **);
  } creator;
  void *handle;
};
using Register = void (*)(Registration *, void *);

void *make_pair(void *lmp) { return new PairJumpDisc(static_cast<LAMMPS *>(lmp)); }

template <class Fix> void *make_fix(void *lmp, int narg, char **arg) { return new Fix(static_cast<LAMMPS *>(lmp), narg, arg); }

}    // namespace

/** Threads that the last step of a run in this process took. */
extern "C" __attribute__((visibility("default"))) int jump_threads() { return jump::threads_now; }

extern "C" __attribute__((visibility("default"))) void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  auto add = reinterpret_cast<Register>(regfunc);
  Registration plugin;
  plugin.version = static_cast<LAMMPS *>(lmp)->version;
  plugin.author = "lammps-jump";
  plugin.handle = handle;

  plugin.style = "pair";
  plugin.name = "jump/disc";
  plugin.info = "contacts of discs in 2-D: laws viscous, sign and history";
  plugin.creator.plain = make_pair;
  add(&plugin, lmp);

  plugin.style = "fix";
  plugin.name = "jump/step";
  plugin.info = "velocity Verlet, gravity and walls for discs in one pass";
  plugin.creator.with_arguments = make_fix<FixJumpStep>;
  add(&plugin, lmp);

  plugin.name = "jump/inlet";
  plugin.info = "rows of discs that flow in";
  plugin.creator.with_arguments = make_fix<FixJumpInlet>;
  add(&plugin, lmp);
}
