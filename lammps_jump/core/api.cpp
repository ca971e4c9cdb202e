// SPDX-License-Identifier: GPL-2.0-or-later
/* What Python compares where it loads the core: version, names of the numbers of a law, columns of arrays (core/columns.py) and what
   numbers stand for. Elementary functions for tests, which hold them against those of other systems: angles in rad. */

#include "api.h"
#include "contact/elementary.h"
#include "contact/law.h"
#include "walls/faces.h"
#include "step/events.h"

#include <cstddef>
#include <string>

JUMP_API int64_t jump_core_version() { return jump::VERSION; }

using jump_law = jump::LawNumbers;
JUMP_SIZE(jump_law)

// Names of the numbers of a law in their order, each followed by a space.
JUMP_API const char *jump_law_fields()
{
#define JUMP_NAME(name) #name " "
  return JUMP_LAW(JUMP_NAME);
#undef JUMP_NAME
}

JUMP_API double jump_sin(double x) { return jump::sine(x); }
JUMP_API double jump_cos(double x) { return jump::cosine(x); }
JUMP_API double jump_atan2(double y, double x) { return jump::arctangent(y, x); }

namespace jump {
namespace {

/** A member of a struct of words of 8 bytes: its name, first word and number of words. */
std::string entry(const char *name, size_t offset, size_t size)
{
  return std::string(" ") + name + "=" + std::to_string(offset / 8) + "+" + std::to_string(size / 8);
}

/** A number that has a name. */
std::string entry(const char *name, int64_t number) { return std::string(" ") + name + "=" + std::to_string(number); }

#define JUMP_MEMBER(of, member) entry(#member, offsetof(of, member), sizeof(of::member))

std::string columns()
{
  std::string text = "Placed";
  text += JUMP_MEMBER(Placed, now) + JUMP_MEMBER(Placed, c) + JUMP_MEMBER(Placed, s) + JUMP_MEMBER(Placed, rate);
  text += JUMP_MEMBER(Placed, centred) + "\nPushed";
  text += JUMP_MEMBER(Pushed, place) + JUMP_MEMBER(Pushed, speed) + JUMP_MEMBER(Pushed, before);
  text += JUMP_MEMBER(Pushed, force) + JUMP_MEMBER(Pushed, phase) + "\nLoad";
  text += JUMP_MEMBER(Load, mass) + JUMP_MEMBER(Load, inertia) + JUMP_MEMBER(Load, force) + JUMP_MEMBER(Load, arm);
  text += JUMP_MEMBER(Load, free) + JUMP_MEMBER(Load, begin) + "\nWallLoads";
  text += JUMP_MEMBER(WallLoads, of_discs) + JUMP_MEMBER(WallLoads, all) + JUMP_MEMBER(WallLoads, dashpots);
  text += JUMP_MEMBER(WallLoads, friction) + "\nSumsOnWall";
  text += JUMP_MEMBER(SumsOnWall, force) + JUMP_MEMBER(SumsOnWall, power) + "\nStepClock";
  text += JUMP_MEMBER(StepClock, step) + JUMP_MEMBER(StepClock, start) + JUMP_MEMBER(StepClock, dt);
  text += JUMP_MEMBER(StepClock, half_skin) + JUMP_MEMBER(StepClock, extrapolates) + "\nWork";
  text += JUMP_MEMBER(Work, whole) + JUMP_MEMBER(Work, of_walls) + "\nWorkParts";
  text += JUMP_MEMBER(WorkParts, dashpots) + JUMP_MEMBER(WorkParts, friction) + JUMP_MEMBER(WorkParts, walls) + "\nTrackRow";
  text += JUMP_MEMBER(TrackRow, begin) + JUMP_MEMBER(TrackRow, x) + JUMP_MEMBER(TrackRow, y) + JUMP_MEMBER(TrackRow, angle);
  text += JUMP_MEMBER(TrackRow, wave) + JUMP_MEMBER(TrackRow, rate) + JUMP_MEMBER(TrackRow, phase);
  return text;
}

#define JUMP_NUMBER(name) entry(#name, name)

std::string numbers()
{
  std::string text = "WallMotion";
  text += JUMP_NUMBER(STANDS) + JUMP_NUMBER(FOLLOWS) + JUMP_NUMBER(LOADED) + JUMP_NUMBER(TAILGATE) + JUMP_NUMBER(BODY);
  text += "\nPhase" + JUMP_NUMBER(IS_HELD) + JUMP_NUMBER(IS_RELEASED) + JUMP_NUMBER(HAS_MOVED);
  text += "\nStationSum" + JUMP_NUMBER(MASS_LEFT) + JUMP_NUMBER(MASS_RIGHT) + JUMP_NUMBER(CARRIED) + JUMP_NUMBER(CONTACTS);
  text += JUMP_NUMBER(WALLS) + JUMP_NUMBER(DASHPOTS) + JUMP_NUMBER(FRICTION) + JUMP_NUMBER(BEGAN) + JUMP_NUMBER(HELD);
  text += "\nRunEnd" + JUMP_NUMBER(AT_TARGET) + JUMP_NUMBER(NO_LISTS) + JUMP_NUMBER(TOO_DEEP) + JUMP_NUMBER(NO_SLOT);
  text += "\nExchange" + JUMP_NUMBER(BROUGHT_IN) + JUMP_NUMBER(CARRIED_OUT) + JUMP_NUMBER(RELEASED_BY_GATES);
  text += "\nTraffic" + JUMP_NUMBER(INSERTED) + JUMP_NUMBER(REMOVED) + JUMP_NUMBER(SIZED);
  text += "\nFaceKind" + JUMP_NUMBER(SEGMENT) + JUMP_NUMBER(ARC);
  text += "\nJoint" + JUMP_NUMBER(CONVEX) + JUMP_NUMBER(SMOOTH) + JUMP_NUMBER(CORNER) + JUMP_NUMBER(FREE) + JUMP_NUMBER(ENDLESS);
  return text;
}

}    // namespace
}    // namespace jump

/** A line for each struct and each list of numbers: its name, then its members and where they are. */
JUMP_API const char *jump_columns()
{
  static const std::string text = jump::columns() + "\n" + jump::numbers();
  return text.c_str();
}
