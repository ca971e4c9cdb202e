"use strict";
// Curves over time and distance.
