/* What tests of the library share: a world over a small terrain of hills, and checks of statuses with their messages. */
#ifndef FURROW_TESTS_HOSTED_H
#define FURROW_TESTS_HOSTED_H

#include "../support.h"
#include "../support/skip.h"

#include "api/furrow.h"

static const struct extent hosted_extent = {129, 129, 0.25, 32};

#define HOSTED_SCENE \
	"{\"scene\": 1, \"time_step\": 0.01, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"scm\"}}"
#define HOSTED_BALL "{shape: {sphere: {radius: 0.5}}}"

static inline double hosted_flat(int64_t x, int64_t y)
{
	return 100;
}

/* The call is done, or the test is skipped for want of GL. */
#define done(call)                                                                       \
	do {                                                                             \
		const furrow_status status_of_call = (call);                             \
		if (status_of_call == FURROW_NO_GL)                                      \
			skip_since("no GL");                                             \
		if (status_of_call != FURROW_OK) {                                       \
			print_error("%s: %s\n", #call, furrow_last_error());            \
			assert_int_equal(status_of_call, FURROW_OK);                     \
		}                                                                        \
	} while (0)

/* The call is refused with this status and a whole message: WHAT: WHY; WHAT TO DO. */
#define refused(status, call)                                                            \
	do {                                                                             \
		const furrow_status status_of_call = (call);                             \
		const char *said = furrow_last_error();                                  \
		if (status_of_call != (status) || strstr(said, ": ") == NULL || strstr(said, "; ") == NULL) \
			print_error("%s:%d: %s: %d, \"%s\"\n", __FILE__, __LINE__, #call, (int)status_of_call, said); \
		assert_int_equal(status_of_call, status);                                \
		assert_non_null(strstr(said, ": "));                                     \
		assert_non_null(strstr(said, "; "));                                     \
	} while (0)
#define misused(call) refused(FURROW_USAGE, call)

static inline struct furrow_open hosted_open(const char *scene, const char *store)
{
	struct furrow_open open = {.size = sizeof open, .scene = scene, .store = store};
	return open;
}

/* A new store of that ground, and a world over it. */
static inline struct furrow_world *hosted_world_over(const char *name, const char *scene, support_height ground)
{
	const char *store = support_path(name);
	struct furrow_world *world = NULL;
	support_store(store, hosted_extent, ground);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &world));
	assert_non_null(world);
	return world;
}

static inline struct furrow_world *hosted_world(const char *name)
{
	return hosted_world_over(name, HOSTED_SCENE, hosted_flat);
}

static inline struct furrow_pose hosted_pose(double x, double y, double z)
{
	return (struct furrow_pose){{x, y, z}, {1, 0, 0, 0}};
}

static inline struct furrow_state hosted_state(double x, double y, double z)
{
	return (struct furrow_state){.pose = {{x, y, z}, {1, 0, 0, 0}}};
}

/* A ball that lies on the ground there. */
static inline furrow_body hosted_ball(struct furrow_world *world, double x, double y)
{
	furrow_body ball = -1;
	const struct furrow_pose pose = hosted_pose(x, y, 100.5);
	done(furrow_body_add(world, HOSTED_BALL, &ball));
	done(furrow_place(world, ball, &pose));
	return ball;
}

/* The ball goes there, in a step. */
static inline void hosted_move(struct furrow_world *world, furrow_body ball, double x, double y, double z)
{
	const struct furrow_state state = hosted_state(x, y, z);
	done(furrow_set_states(world, 1, &ball, &state));
	done(furrow_step(world, 0));
}

/* A layer of the whole working level; freed by the caller. */
static inline double *hosted_read(struct furrow_world *world, enum furrow_layer layer, struct furrow_info *info)
{
	info->size = sizeof *info;
	done(furrow_info(world, info));
	double *posts = malloc((size_t)(info->columns * info->rows) * sizeof *posts);
	assert_non_null(posts);
	done(furrow_read(world, layer, info->level, 0, 0, (uint32_t)info->columns, (uint32_t)info->rows, posts, (size_t)info->columns));
	return posts;
}

/* Writes drum.obj, a mesh of a wheel whose axle is y: an even prism, with its corners on that radius. m */
static inline void hosted_write_drum(double radius, double width, int facets)
{
	static char text[16384];
	size_t at = 0;
	for (int i = 0; i < facets; i++)
		for (int k = 0; k < 2; k++)
			at += (size_t)snprintf(text + at, sizeof text - at, "v %.9g %g %.9g\n", radius * sin(2 * M_PI * i / facets), k ? width / 2 : -width / 2,
					       radius * cos(2 * M_PI * i / facets));
	for (int i = 0; i < facets; i++)
		at += (size_t)snprintf(text + at, sizeof text - at, "f %d %d %d %d\n", 2 * i + 1, 2 * i + 2, 2 * ((i + 1) % facets) + 2, 2 * ((i + 1) % facets) + 1);
	for (int k = 0; k < 2; k++) {
		at += (size_t)snprintf(text + at, sizeof text - at, "f");
		for (int i = 0; i < facets; i++)
			at += (size_t)snprintf(text + at, sizeof text - at, " %d", k ? 2 * (facets - i) : 2 * i + 1);
		at += (size_t)snprintf(text + at, sizeof text - at, "\n");
	}
	assert_true(at < sizeof text);
	support_write(support_path("drum.obj"), text);
}

#endif
