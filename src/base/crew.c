/*
 * Threads that share the tasks of one call.
 *
 * Each member has a range of tasks and takes them from its front. A member whose range is empty takes the last task of the longest
 * range. So neighbours stay with one member, which may keep in its caches what they have in common.
 *
 * Invariant: `busy` counts the threads that have seen the present call and not left it. A call ends when it is 0 and no task is left.
 */
#include "base/crew.h"

struct range {
	size_t next, end;
};

struct member {
	struct crew *crew;
	size_t number;
	struct thread thread;
};

struct crew {
	struct mutex mutex;
	struct condition changed;
	struct member *members;
	struct range *ranges; /* of the present call */
	size_t count;         /* members */
	uint64_t calls;       /* begun so far */
	size_t busy;
	bool ended;
	crew_hook_fn enter, leave;
	crew_task_fn task;
	void *user;
	struct failure failure;
};

/* Call with the mutex held. Returns false if no task is left. */
static bool take(struct crew *crew, size_t member, size_t *task)
{
	struct range *own = &crew->ranges[member], *longest = own;
	if (crew->failure.status != STATUS_OK)
		return false;
	for (size_t i = 0; own->next == own->end && i < crew->count; i++)
		if (crew->ranges[i].end - crew->ranges[i].next > longest->end - longest->next)
			longest = &crew->ranges[i];
	if (longest->next == longest->end)
		return false;
	*task = longest == own ? longest->next++ : --longest->end;
	return true;
}

/* Call with the mutex held, which is released while a task runs. */
static void work(struct crew *crew, size_t member)
{
	size_t task;
	while (take(crew, member, &task)) {
		mutex_unlock(&crew->mutex);
		enum status status = crew->task(crew->user, member, task);
		struct failure failure;
		failure_capture(&failure, status);
		mutex_lock(&crew->mutex);
		if (status != STATUS_OK && crew->failure.status == STATUS_OK)
			crew->failure = failure;
	}
}

static void *live(void *argument)
{
	struct member *member = argument;
	struct crew *crew = member->crew;
	uint64_t seen = 0;
	if (crew->enter != NULL)
		crew->enter();
	mutex_lock(&crew->mutex);
	for (;;) {
		while (!crew->ended && seen == crew->calls)
			condition_wait(&crew->changed, &crew->mutex);
		if (crew->ended)
			break;
		seen = crew->calls;
		crew->busy++;
		work(crew, member->number);
		crew->busy--;
		condition_wake_all(&crew->changed);
	}
	mutex_unlock(&crew->mutex);
	if (crew->leave != NULL)
		crew->leave();
	return NULL;
}

enum status crew_create(size_t members, const char *name, crew_hook_fn enter, crew_hook_fn leave, struct crew **out)
{
	struct crew *crew = mem_calloc(1, sizeof *crew);
	TRY_MEM(crew, "threads");
	crew->enter = enter;
	crew->leave = leave;
	mutex_init(&crew->mutex);
	condition_init(&crew->changed);
	crew->members = mem_calloc(members, sizeof *crew->members);
	crew->ranges = mem_calloc(members, sizeof *crew->ranges);
	enum status status;
	TRY_OR(failed, crew->members != NULL && crew->ranges != NULL ? STATUS_OK : fail_memory("threads"));
	for (; crew->count < members; crew->count++) {
		struct member *member = &crew->members[crew->count];
		*member = (struct member){.crew = crew, .number = crew->count};
		if (crew->count > 0)
			TRY_OR(failed, thread_start(&member->thread, live, member, name));
	}
	*out = crew;
	return STATUS_OK;
failed:
	crew_destroy(crew);
	return status;
}

void crew_destroy(struct crew *crew)
{
	if (crew == NULL)
		return;
	mutex_lock(&crew->mutex);
	crew->ended = true;
	condition_wake_all(&crew->changed);
	mutex_unlock(&crew->mutex);
	for (size_t i = 0; i < crew->count; i++)
		thread_join(&crew->members[i].thread);
	condition_finish(&crew->changed);
	mutex_finish(&crew->mutex);
	mem_free_all(crew->members, crew->ranges, crew);
}

enum status crew_run(struct crew *crew, size_t count, crew_task_fn task, void *user)
{
	if (count == 1 || crew->count == 1) { /* nobody need be woken */
		for (size_t i = 0; i < count; i++)
			TRY(task(user, 0, i));
		return STATUS_OK;
	}
	mutex_lock(&crew->mutex);
	crew->task = task;
	crew->user = user;
	crew->failure.status = STATUS_OK;
	for (size_t i = 0; i < crew->count; i++)
		crew->ranges[i] = (struct range){count * i / crew->count, count * (i + 1) / crew->count};
	crew->calls++;
	condition_wake_all(&crew->changed);
	work(crew, 0);
	while (crew->busy > 0)
		condition_wait(&crew->changed, &crew->mutex);
	/* A thread that wakes only now finds no task; after a failure those that are left must not be done later. */
	for (size_t i = 0; i < crew->count; i++)
		crew->ranges[i] = (struct range){0, 0};
	const struct failure failure = crew->failure;
	mutex_unlock(&crew->mutex);
	return failure.status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}
