/* Tells a user that a rank waits for the others, and for how long. MPI itself waits for ever, and says nothing. */
#ifndef FURROW_FLEET_WATCH_H
#define FURROW_FLEET_WATCH_H

/* Starts the thread that tells. Without it, where it cannot be started, all functions do nothing. */
void fleet_watch_start(void);
void fleet_watch_finish(void); /* does nothing if it was not started */

/* The calling thread begins to wait for other ranks. A line on stderr tells so if it lasts for more than `seconds`, then again each time it
 * has lasted twice as long. `rank`: this one; only the first two tell. -1: not known yet, which waits for the others to start. */
void fleet_watch_begin(int rank, double seconds);
void fleet_watch_end(void); /* it goes on */

#endif
