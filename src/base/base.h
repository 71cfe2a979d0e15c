/*
 * base: what every part of Furrow uses. No GL, no SQLite, no GDAL.
 *
 * It has statuses and messages, memory that can be made to fail, threads, and a clock. It defines the lattice: tiles, levels,
 * and integer heights. It also has the three pure functions that every part shares: decimation, interpolation and rounding to
 * the lattice. Any thread may call any function, unless its comment says otherwise.
 */
#ifndef FURROW_BASE_H
#define FURROW_BASE_H

#include "base/c_locale.h"
#include "base/clock.h"
#include "base/height_code.h"
#include "base/input.h"
#include "base/lattice.h"
#include "base/memory.h"
#include "base/misfit.h"
#include "base/number.h"
#include "base/plan.h"
#include "base/plane.h"
#include "base/relief.h"
#include "base/shell.h"
#include "base/status.h"
#include "base/thread.h"
#include "base/tile.h"

#endif
