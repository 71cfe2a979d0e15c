/* The library itself: version, messages, the log, and the begin and end of each call. */
#include "api/library.h"

#include <pthread.h>
#include <unistd.h>

#include "dem/dem.h"

#define TRIES_MOST 16 /* of a query beside a writer */
#define SIZE_MOST 4096 /* bytes: more than any version of a struct of furrow.h will have */

/* --- messages --- */

static _Thread_local char error[sizeof(((struct failure *)0)->message)];

const char *furrow_version(void)
{
	return FURROW_VERSION;
}

const char *furrow_last_error(void)
{
	return error;
}

void furrow_free(void *memory)
{
	mem_free(memory);
}

/* --- the log --- */

static pthread_rwlock_t log_lock = PTHREAD_RWLOCK_INITIALIZER;
static void (*log_function)(int level, const char *message, void *user);
static void *log_user;

static void take_note(const char *text)
{
	pthread_rwlock_rdlock(&log_lock);
	if (log_function != NULL) {
		const locale_t locale = api_library_to_host();
		log_function(0, text, log_user);
		api_library_from_host(locale);
	}
	pthread_rwlock_unlock(&log_lock);
}

static void begin_once(void)
{
	note_to(take_note);
}

static void take_notes(void)
{
	static pthread_once_t once = PTHREAD_ONCE_INIT;
	pthread_once(&once, begin_once);
}

void furrow_set_log(void (*log)(int level, const char *message, void *user), void *user)
{
	take_notes();
	pthread_rwlock_wrlock(&log_lock);
	log_function = log;
	log_user = user;
	pthread_rwlock_unlock(&log_lock);
}

/* --- calls --- */

static _Thread_local locale_t host_locale; /* that this thread had before its call of the library; (locale_t)0 in the library's own threads */

locale_t api_library_to_host(void)
{
	return uselocale(host_locale != (locale_t)0 ? host_locale : LC_GLOBAL_LOCALE);
}

void api_library_from_host(locale_t locale)
{
	host_locale = uselocale(locale);
}

enum status api_library_begin(void)
{
	locale_t locale;
	take_notes();
	const enum status status = c_locale(&locale);
	host_locale = uselocale(locale);
	dem_quiet_begin();
	return status;
}

furrow_status api_library_end(enum status status)
{
	dem_quiet_end();
	uselocale(host_locale);
	if (status != STATUS_OK)
		snprintf(error, sizeof error, "%s", failure_message());
	return (furrow_status)status_exit_code(status);
}

enum status api_library_enter(struct library_call *call, struct furrow_world *world)
{
	*call = (struct library_call){.world = NULL};
	TRY(api_library_begin());
	TRY(api_library_need_world(world));
	call->world = world;
	world->call = call;
	page_cache_adopt(world_resident(world->world)->cache); /* another thread may have used the world before */
	if (world_resident(world->world)->gpu == NULL)
		return STATUS_OK;
	call->gl = true;
	gpu_keep(world_resident(world->world)->gpu, &call->kept);
	return gpu_take(world_resident(world->world)->gpu);
}

void api_library_begin_gl(struct furrow_world *world)
{
	if (world->call == NULL || world->call->gl)
		return;
	world->call->gl = true;
	gpu_keep(NULL, &world->call->kept);
}

furrow_status api_library_leave(struct library_call *call, enum status status)
{
	if (call->gl)
		gpu_give(&call->kept);
	return api_library_end(status);
}

enum status api_library_need(const void *pointer, const char *name)
{
	return pointer != NULL ? STATUS_OK : fail_with(STATUS_USAGE, "%s: it is NULL; give one", name);
}

enum status api_library_need_count(size_t count, size_t bytes)
{
	return count <= PTRDIFF_MAX / bytes ? STATUS_OK
					    : fail_with(STATUS_USAGE, "count: %zu entries are more than memory has; give the number of your entries", count);
}

enum status api_library_need_world(const struct furrow_world *world)
{
	if (world == NULL || world->process == (int64_t)getpid())
		return api_library_need(world, "world");
	/* The struct is the child's own copy, in memory that this library has allocated. */
	bool *forked = (bool *)(uintptr_t)&world->forked;
	if (!*forked)
		world_forked(world->world);
	*forked = true;
	return fail_with(STATUS_USAGE, "world: process %lld opened it, and this is a child of that process, without its threads; use it there, or start the "
				       "child as a program of its own (exec, or spawn in Python)", (long long)world->process);
}

/* A struct's size is a multiple of its first member's. */
enum status api_library_need_size(size_t size, size_t least, size_t known, const char *name)
{
	if (size >= least && size <= SIZE_MOST && size % sizeof size == 0)
		return STATUS_OK;
	return fail_with(STATUS_USAGE, "%s: its size is %zu; set it to sizeof(struct furrow_%s), %zu", name, size, name, known);
}

enum status api_library_need_writable(const struct furrow_world *world, const char *what)
{
	return !world_params(world->world)->readonly
		       ? STATUS_OK
		       : fail_with(STATUS_USAGE, "%s: the world is readonly, and this would change it; open it without readonly to change it", what);
}

enum status api_library_settle(struct furrow_world *world)
{
	if (world_is_torn(world->world))
		return fail_with(STATUS_FAILED, "world: its last step failed half-way; roll back first, or close it");
	const enum status status = world_follow(world->world);
	return status == STATUS_OK ? world_hosts_commit(world->world) : status;
}

bool api_library_again(struct furrow_world *world, int tries, enum status *status)
{
	bool moved = false;
	if (*status != STATUS_OK)
		return false;
	*status = world_has_moved(world->world, &moved);
	if (*status != STATUS_OK || !moved)
		return false;
	if (tries >= TRIES_MOST)
		*status = fail_with(STATUS_FAILED, "%s: another process commits to it more often than it can be read; ask for less at a time", world_facts(world->world)->path);
	return *status == STATUS_OK;
}
