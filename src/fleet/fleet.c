/* The life of a fleet, and its exchanges. Every exchange tells the status of all ranks, so that all of them go on or none does. */
#include "fleet/internal.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static struct {
	int rank, ranks; /* ranks 0: not joined */
} joined;

struct head {
	int32_t kind, status;
	int32_t stop, due, torn, leaves;
	int64_t step;
	char message[480];
};

static void say_nothing(const char *text)
{
	(void)text;
}

bool fleet_is_launched(void)
{
	return fleet_comm_launched();
}

enum status fleet_join(void)
{
	TRY(fleet_comm_start(&joined.rank, &joined.ranks));
	if (joined.rank > 0)
		note_to(say_nothing);
	return STATUS_OK;
}

void fleet_leave(void)
{
	if (joined.ranks > 0)
		fleet_comm_finish();
	joined.ranks = 0;
}

bool fleet_speaks(void)
{
	return joined.rank == 0;
}

/* --- bytes --- */

enum status fleet_put(struct fleet_bytes *bytes, const void *from, size_t size)
{
	TRY(mem_grow(&bytes->bytes, &bytes->room, bytes->size + size, 1, "a message to ranks"));
	if (size > 0)
		memcpy(bytes->bytes + bytes->size, from, size);
	bytes->size += size;
	return STATUS_OK;
}

enum status fleet_get(struct fleet_bytes *bytes, void *to, size_t size)
{
	if (size > bytes->size - bytes->at)
		return fail_with(STATUS_FAILED, "ranks: a message is shorter than it should be; start all ranks with the same version of furrow and the same options");
	if (size > 0)
		memcpy(to, bytes->bytes + bytes->at, size);
	bytes->at += size;
	return STATUS_OK;
}

/* --- exchanges --- */

/* Finds the failure of the lowest rank that has one. */
static enum status worst(const void *const *all, const size_t *sizes, int ranks, int kind)
{
	struct head head;
	bool differ = false;
	for (int i = 0; i < ranks; i++) {
		if (sizes[i] < sizeof head)
			return fail_with(STATUS_FAILED, "rank %d: it tells too little; start all ranks with the same version of furrow and the same options", i);
		memcpy(&head, all[i], sizeof head);
		head.message[sizeof head.message - 1] = '\0';
		if (head.status != STATUS_OK && head.status != STATUS_INTERRUPTED)
			return i > 0 ? fail_with((enum status)head.status, "rank %d: %s", i, head.message) :
				       fail_with((enum status)head.status, "%s", head.message);
		differ = differ || head.kind != kind;
	}
	return differ ? fail_with(STATUS_FAILED, "ranks: they are not at the same place of the run; start all ranks with the same version of furrow and the same options") : STATUS_OK;
}

static void fill_head(struct head *head, enum fleet_kind kind, enum status status)
{
	memset(head, 0, sizeof *head);
	head->kind = kind;
	head->status = status;
	if (status != STATUS_OK)
		snprintf(head->message, sizeof head->message, "%s", failure_message());
}

enum status fleet_agree(enum status status)
{
	struct head head;
	const void *const *all;
	const size_t *sizes;
	if (joined.ranks == 0)
		return status;
	fill_head(&head, FLEET_AGREE, status);
	fleet_comm_exchange(&head, sizeof head, &all, &sizes);
	const enum status other = worst(all, sizes, joined.ranks, FLEET_AGREE);
	return other != STATUS_OK ? other : status;
}

struct fleet_wait fleet_wait_begin(void)
{
	return (struct fleet_wait){clock_seconds(), clock_thread_seconds()};
}

void fleet_wait_end(struct fleet *fleet, struct fleet_wait wait)
{
	fleet->waited += clock_seconds() - wait.clock;
	fleet->spun += clock_thread_seconds() - wait.processor;
}

void fleet_meet(void)
{
	struct head head;
	const void *const *all;
	const size_t *sizes;
	fill_head(&head, FLEET_AGREE, STATUS_OK);
	fleet_comm_exchange(&head, sizeof head, &all, &sizes);
}

/* Before the world is opened, and when it is freed, there is none. */
static int64_t step_of(const struct fleet *fleet)
{
	return fleet->world != NULL ? world_steps_done(fleet->world) : 0;
}

static bool is_torn(const struct fleet *fleet)
{
	return fleet->world != NULL && world_is_torn(fleet->world);
}

static bool is_due(const struct fleet *fleet)
{
	struct page_cache *cache = fleet->world != NULL ? world_resident(fleet->world)->cache : NULL;
	return cache != NULL && page_cache_commit_due(cache);
}

enum status fleet_begin(struct fleet *fleet, enum fleet_kind kind, enum status status)
{
	struct head head;
	fill_head(&head, kind, status);
	head.stop = fleet->params.stop != NULL && *fleet->params.stop;
	head.due = status == STATUS_OK && is_due(fleet);
	head.torn = is_torn(fleet);
	head.step = step_of(fleet);
	head.leaves = kind == FLEET_STEP && fleet->leaves;
	fleet->sent.size = fleet->sent.at = 0;
	return fleet_put(&fleet->sent, &head, sizeof head);
}

enum status fleet_tell(struct fleet *fleet, enum fleet_kind kind, enum status status, struct fleet_told *told, fleet_each_fn each, void *user)
{
	struct head head;
	const void *const *all;
	const size_t *sizes;
	if (status != STATUS_OK) { /* the others wait, so tell them */
		fill_head(&head, kind, status);
		head.torn = is_torn(fleet);
		head.step = step_of(fleet);
		fleet->sent.size = 0;
		if (fleet_put(&fleet->sent, &head, sizeof head) != STATUS_OK)
			assert(fleet->sent.room >= sizeof head); /* made in fleet_open */
	}
	const struct fleet_wait wait = fleet_wait_begin();
	fleet_comm_exchange(fleet->sent.bytes, fleet->sent.size, &all, &sizes);
	fleet_wait_end(fleet, wait);
	fleet->exchanges++;
	*told = (struct fleet_told){false, false, false};
	const int64_t at_step = step_of(fleet);
	const enum status any = worst(all, sizes, fleet->ranks, kind);
	for (int i = 0; i < fleet->ranks && sizes[i] >= sizeof head; i++) {
		memcpy(&head, all[i], sizeof head);
		told->stop = told->stop || head.stop;
		told->due = told->due || head.due;
		told->leaves = told->leaves || head.leaves;
		/* A step that only some ranks have made must not be committed. */
		if (fleet->world != NULL && any != STATUS_OK && (head.torn || head.kind != (int32_t)kind || head.step != at_step))
			world_tear(fleet->world);
	}
	fleet->failed = fleet->failed || any != STATUS_OK;
	enum status status_each = any;
	for (int i = 0; i < fleet->ranks && each != NULL && status_each == STATUS_OK; i++) {
		struct fleet_bytes bytes = {.bytes = (char *)all[i], .size = sizes[i], .at = sizeof head};
		status_each = each(user, i, &bytes);
	}
	/* Ranks whose head was well go on, and would wait for this one. What ranks have in common differs on all of them. */
	if (status_each != STATUS_OK && any == STATUS_OK && kind != FLEET_AGREE)
		fleet_comm_give_up(failure_message());
	fleet->failed = fleet->failed || status_each != STATUS_OK;
	return status_each;
}

/* --- life --- */

const struct world_ranks *fleet_ranks(struct fleet *fleet)
{
	fleet->hooks = (struct world_ranks){
		.user = fleet,
		.rank = fleet->rank,
		.ranks = fleet->ranks,
		.over = fleet->over,
		.part = fleet->part,
		.step = fleet_step,
		.probed = fleet_probed,
		.newest = fleet_newest,
		.rows = fleet_rows_take,
		.changes = fleet_changes,
		.has = fleet_has,
		.loads = fleet_loads,
		.end = fleet_end,
		.gather = fleet_gather,
		.agree = fleet_agree_on,
	};
	return &fleet->hooks;
}

const struct store_staged *fleet_staged(const struct fleet *fleet)
{
	return fleet->staged.original != NULL ? &fleet->staged : NULL;
}

const volatile sig_atomic_t *fleet_stop(const struct fleet *fleet)
{
	return &fleet->stop;
}

int fleet_joined(int *rank)
{
	*rank = joined.rank;
	return joined.ranks;
}
