/*
 * Calls of MuJoCo whose errors become a status.
 *
 * MuJoCo ends the process on an error, and writes warnings to a file of the current folder. Both are done by functions that a
 * process may replace, for all of its threads. They are replaced only while a call of this file runs. An error of another thread
 * goes to the function that was there before.
 */
#ifndef FURROW_VEHICLE_GUARD_H
#define FURROW_VEHICLE_GUARD_H

#include "base/base.h"

/* Runs `call`. STATUS_FAILED: MuJoCo reported an error; the message begins with `what`. Memory that MuJoCo had in use then is
 * lost. */
enum status vehicle_guard(const char *what, void (*call)(void *argument), void *argument) FURROW_CHECKED;
/* Returns the first warning of the last guarded call of this thread; "" if there was none. */
const char *vehicle_guard_warning(void);

#endif
