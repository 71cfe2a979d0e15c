/*
 * Shared by the files that implement furrow.h: how each function of the library begins and ends, and the struct furrow_world.
 */
#ifndef FURROW_API_LIBRARY_H
#define FURROW_API_LIBRARY_H

#include "drive/drive.h"
#include "api/furrow.h"
#include "base/base.h"
#include "gpu/gpu.h"
#include "render/render.h"
#include "report/report.h"
#include "scene/scene.h"
#include "vehicle/vehicle.h"
#include "world/world.h"

struct furrow_world {
	struct drive *drive;
	struct world *world;       /* the drive's */
	struct vehicles *vehicles; /* the drive's; NULL: the scene has none */
	int64_t process;           /* number of the process that opened it */
	bool forked;               /* this is a child of that process, and has let go of the world's locks */
	struct scene *scene;
	char *output;              /* NULL: nothing is written */
	struct library_call *call; /* the last one that entered */
	double origin;             /* s: time from which steps of time_step are counted */
	int64_t steps;             /* steps since then */
	struct library_mark {      /* values of `origin` and `steps` at the last checkpoint */
		double origin;
		int64_t steps;
	} mark;
	bool failed;               /* the last step failed, and nothing was rolled back since */
	double busy;               /* s, by the clock, in furrow_step */
	int64_t checkpoints;       /* how many were made */
	struct furrow_mujoco *soils; /* furrow_mujoco.c: the list of those that are open */
};

/* State of one call of the library by its host. It keeps the host's GL context, which is restored when the call ends. */
struct library_call {
	/* the world of the call; NULL if there is none, or if the call has not made its GL context current */
	struct furrow_world *world;
	bool gl; /* the world's GL context is current; the thread's own is in `kept` */
	struct gpu_kept kept;
};

/* Begin and end a call without GL. Between them the thread has the locale "C". End a call whatever its begin returns. The end returns the
 * host's status, and keeps the message of a failure for it. */
enum status api_library_begin(void) FURROW_CHECKED;
furrow_status api_library_end(enum status status);
/* Before and after a call of the host's own function: it has the host's locale. The first returns the thread's locale for the second. */
locale_t api_library_to_host(void);
void api_library_from_host(locale_t locale);
/* The same for a call that uses the world's GL. STATUS_USAGE: `world` is NULL. End with api_library_leave, whatever it returns. */
enum status api_library_enter(struct library_call *call, struct furrow_world *world) FURROW_CHECKED;
/* Before a world whose drive needs no GL makes a context, for a picture. */
void api_library_begin_gl(struct furrow_world *world);
furrow_status api_library_leave(struct library_call *call, enum status status);

/* furrow_steps.c: makes a step, as furrow_step does. */
enum status api_library_step(struct furrow_world *host, double seconds) FURROW_CHECKED;
/* The same file: makes a checkpoint. */
enum status api_library_checkpoint(struct furrow_world *host) FURROW_CHECKED;
/* furrow_mujoco.c: before the world goes, all soils in it let go of it. */
void api_library_let_go_soils(struct furrow_world *host);
/* Checks that the world may be changed. STATUS_USAGE: it is readonly. `what`: the call. */
enum status api_library_need_writable(const struct furrow_world *world, const char *what) FURROW_CHECKED;
/* Checks that a world is not NULL, and is of this process. STATUS_USAGE: it is not. In a child of the world's process lets go of its locks. */
enum status api_library_need_world(const struct furrow_world *world) FURROW_CHECKED;
/* Checks that an argument is not NULL. If it is: STATUS_USAGE, with a message that has `name`. */
enum status api_library_need(const void *pointer, const char *name) FURROW_CHECKED;
/* Checks a count of entries of `bytes` each. STATUS_USAGE: they are more than an array can have. */
enum status api_library_need_count(size_t count, size_t bytes) FURROW_CHECKED;
/* Checks the `size` of a struct furrow_`name` of the host. `least`: that of its first version; `known`: that of this library's version. A later
 * version is larger. STATUS_USAGE: no version has that size. */
enum status api_library_need_size(size_t size, size_t least, size_t known, const char *name) FURROW_CHECKED;
/* Commits the motion of the host's bodies, so that a query sees the ground as it is. A readonly world sees what others have committed. */
enum status api_library_settle(struct furrow_world *world) FURROW_CHECKED;
/* After a query that returned *status: returns true if it is to be made again, with api_library_settle() first, since another process has
 * committed meanwhile. `tries`: how often it was made. *status gets a failure. */
bool api_library_again(struct furrow_world *world, int tries, enum status *status);

#endif
