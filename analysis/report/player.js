"use strict";
// The player. The page without scripts is whole: this file adds to it.
