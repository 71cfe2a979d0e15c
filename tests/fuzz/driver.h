/* The parts of the driver: its corpus, and its changes of bytes. */
#ifndef FURROW_FUZZ_DRIVER_H
#define FURROW_FUZZ_DRIVER_H

#include "fuzz.h"

struct input {
	uint8_t *data;
	size_t size; /* at least 1 */
};

/* One of the corpus, which is never empty while there are changes to make. */
const struct input *driver_any_input(void);
extern uint64_t driver_random_state; /* of the input being made */

#endif
