/* Every Nth call of a kind fails, once and for good; and what a test says when that goes wrong. */
#ifndef FURROW_TEST_FAULT_SWEEP_H
#define FURROW_TEST_FAULT_SWEEP_H

#include "../long.h"
#include "../store/fixture.h"
#include "fault_vfs.h"

/* The fault that a trial is to arm: with fault_arm_for(), so that what fails can be named. */
struct fault {
	enum fault_kind kind;
	uint64_t nth;
	bool forever;
};

static char trial_name[96]; /* what is being tried, for a person */
static bool trial_unopened; /* a file may be one that cannot be opened: that is the input's fault */

#define expect(condition)                                                                          \
	do {                                                                                       \
		if (!(condition))                                                                  \
			fail_msg("%s: not so: %s (%s)", trial_name, #condition, failure_message()); \
	} while (0)

static UNUSED void fault_arm_for(const struct fault *fault)
{
	snprintf(trial_name, sizeof trial_name, "%s %llu%s", fault_name(fault->kind),
		 (unsigned long long)fault->nth, fault->forever ? " and on" : "");
	trial_unopened = fault->kind == FAULT_OPEN;
	fault_arm(fault->kind, fault->nth, fault->forever);
}

/* A failure that was told: its status, and a message of the form WHAT: WHY; WHAT TO DO. It is the
 * machine's failure and not the input's, but for a file that cannot be opened. */
static UNUSED bool told(enum status status)
{
	const char *message = failure_message();
	bool good = status == STATUS_FAILED || (status == STATUS_INPUT && trial_unopened);
	const char *why = strstr(message, ": ");
	good = good && why != NULL && strstr(why, "; ") != NULL;
	if (good) /* the next failure has to bring its own */
		(void)!fail_with(STATUS_OK, "no message");
	return good;
}

/* Returns how many calls of the fault's kind it made. */
typedef uint64_t (*trial_fn)(const void *user, const struct fault *fault);

/* Which calls of those that a sweep reaches fail once, and which from then on. */
enum lasting {
	BOTH,       /* each once, and again from then on */
	ONE_BY_ONE, /* the first once, the second from then on, and so on */
	IN_TURN,    /* the first from then on, the second once, and so on */
};

/* A sweep takes one of so many calls, another in each way and with each commit. In the long run it takes one of four with sanitizers, and each
 * without them. */
#ifdef __SANITIZE_ADDRESS__
#define SWEEP_PART (long_run() ? 4u : 8u)
#else
#define SWEEP_PART (long_run() ? 1u : 4u)
#endif

/* At most about `most` Ns spread over the calls that a trial without a fault makes; returns how many
 * were reached. With FAULT_COUNTS in the environment they are told.
 *
 * Where the same calls are swept in several ways, BOTH in one of them and ONE_BY_ONE or IN_TURN in the others cover all pairs: each
 * N in each way, each N both once and from then on, each way both as well. */
static UNUSED uint64_t sweep_lasting(trial_fn trial, const void *user, enum fault_kind kind, uint64_t most, enum lasting lasting)
{
	uint64_t ran = 0;
	for (int pass = 0; pass < (lasting == BOTH ? 2 : 1); pass++) {
		struct fault fault = {kind, UINT64_MAX, pass == 1};
		uint64_t stride = SWEEP_PART * (trial(user, &fault) / most + 1), tried = 0;
		for (fault.nth = 1 + ((uint64_t)kind + (uint64_t)pass + lasting + commit_number()) % SWEEP_PART;; fault.nth += stride) {
			fault.forever = lasting == BOTH ? pass == 1 : (tried++ + (lasting == IN_TURN)) % 2 == 1;
			uint64_t calls = trial(user, &fault);
			if (calls < fault.nth)
				break;
			ran++;
		}
	}
	if (getenv("FAULT_COUNTS") != NULL)
		print_message("%s: %llu\n", fault_name(kind), (unsigned long long)ran);
	return ran;
}

/* Sweeps every kind of fault in turn, at most about `most` calls of each, and checks that this was worth it. */
static UNUSED void sweep_kinds(trial_fn trial, uint64_t most)
{
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep_lasting(trial, NULL, (enum fault_kind)kind, most, IN_TURN);
	assert_true(ran > 100 / SWEEP_PART);
}

/* Each call both once and from then on. */
static UNUSED uint64_t sweep(trial_fn trial, const void *user, enum fault_kind kind, uint64_t most)
{
	return sweep_lasting(trial, user, kind, most, BOTH);
}

#endif
