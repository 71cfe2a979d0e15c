/*
 * Files of SQLite that hand every call on to the real file behind them: what a VFS for tests starts
 * from. It copies the methods, puts its own in place of some, and calls these from them.
 */
#ifndef FURROW_TEST_FAULT_THROUGH_H
#define FURROW_TEST_FAULT_THROUGH_H

#include <sqlite3.h>

struct through {
	sqlite3_file base;
	sqlite3_file *real; /* its memory lies behind this, or behind what begins with this */
};

extern const sqlite3_io_methods through_methods;

static inline sqlite3_file *through_real(sqlite3_file *file)
{
	return ((struct through *)file)->real;
}

#endif
