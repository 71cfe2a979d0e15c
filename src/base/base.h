/*
 * base: what every part of Furrow stands on. No GL, no SQLite, no GDAL.
 *
 * Statuses and messages, memory that may be told to fail, threads, clock, the words of the
 * lattice (tiles, levels, the integer height lattice) and the three pure functions every part
 * shares: decimation, interpolation and rounding to the lattice. Any thread may call anything
 * here unless a function says otherwise.
 */
#ifndef FURROW_BASE_H
#define FURROW_BASE_H

#include "base/clock.h"
#include "base/height_code.h"
#include "base/lattice.h"
#include "base/memory.h"
#include "base/plan.h"
#include "base/plane.h"
#include "base/status.h"
#include "base/thread.h"
#include "base/tile.h"

#endif
