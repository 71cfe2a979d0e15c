/* What tests of bearing soil share: an even bed of soil in host memory, on a slope or level, and bodies that are pressed into it. */
#ifndef FURROW_TESTS_SOIL_BED_H
#define FURROW_TESTS_SOIL_BED_H

#include <string.h>

#include "soil/sink.h"
#include "soil/probe.h"
#include "soil_test.h"

struct bed {
	struct soil_law law;
	struct soil_planes planes;
	struct soil_work *work;
	struct soil_laid laid[SOIL_CLASSES];
	double slope[2], height; /* of the ground: rise to the east and to the north; m at the south-west post */
	size_t posts;
};

/* A bed of side x side posts. east, north: its slope. */
static inline void bed_init(struct bed *bed, const struct soil_numbers *soil, double spacing, int side, double east, double north)
{
	*bed = (struct bed){.law = {.spacing = spacing, .reference = 1024, .soils = {*soil}, .soil_count = 1}, .slope = {east, north}, .height = 1030};
	bed->posts = (size_t)side * (size_t)side;
	bed->planes = (struct soil_planes){.rect = {0, 0, side, side}, .width = (size_t)side};
	int32_t **const planes[] = {&bed->planes.base, &bed->planes.offset, &bed->planes.deposited, &bed->planes.sinkage, &bed->planes.shear, &bed->planes.dug};
	for (size_t k = 0; k < COUNT(planes); k++)
		assert_non_null(*planes[k] = mem_calloc(bed->posts, sizeof(int32_t)));
	assert_non_null(bed->planes.contact = mem_calloc(bed->posts, 1));
	for (int i = 0; i < side * side; i++)
		bed->planes.base[i] = (int32_t)lround(ldexp(bed->height - 1024 + spacing * (east * (i % side) + north * (i / side)), BASE_BITS));
	for (int i = 0; i < SOIL_CLASSES; i++)
		bed->laid[i] = soil_laid_of(0.5, 0, spacing);
	assert_ok(soil_work_create(&bed->work));
}

/* Lets soil that comes onto a post lie loose there, and passes make it denser: before anything else is done with the bed. */
static inline void bed_loosen(struct bed *bed, double loosening, double hardening)
{
	int32_t **const planes[] = {&bed->planes.settled, &bed->planes.loose, &bed->planes.floor, &bed->planes.density};
	for (size_t k = 0; k < COUNT(planes); k++)
		assert_non_null(*planes[k] = mem_calloc(bed->posts, sizeof(int32_t)));
	bed->law.loosening = loosening;
	bed->law.hardening = hardening;
}

/* Soil comes into all ruts, so deep. */
static inline void bed_fill(struct bed *bed, double deep)
{
	for (size_t k = 0; k < bed->posts; k++)
		if (bed->planes.offset[k] < 0) {
			bed->planes.offset[k] += lattice_offset(deep);
			bed->planes.deposited[k] += lattice_offset(deep);
		}
}

static inline void bed_reset(struct bed *bed)
{
	int32_t *const planes[] = {bed->planes.offset, bed->planes.deposited, bed->planes.sinkage, bed->planes.shear, bed->planes.dug};
	for (size_t k = 0; k < COUNT(planes); k++)
		memset(planes[k], 0, bed->posts * sizeof(int32_t));
	memset(bed->planes.contact, 0, bed->posts);
}

static inline void bed_finish(struct bed *bed)
{
	void *const planes[] = {bed->planes.base, bed->planes.offset, bed->planes.deposited, bed->planes.sinkage, bed->planes.shear, bed->planes.dug, bed->planes.contact,
				bed->planes.settled, bed->planes.loose, bed->planes.floor, bed->planes.density};
	for (size_t k = 0; k < COUNT(planes); k++)
		mem_free(planes[k]);
	soil_work_destroy(bed->work);
}

/* Returns the height of the undisturbed ground, m. */
static inline double bed_ground(const struct bed *bed, double x, double y)
{
	return bed->height + bed->slope[0] * x + bed->slope[1] * y;
}

/* Where a body is: m from the south-west post, its axes forward, left and up. */
struct bed_state {
	double at[3], axes[3][3];
};

static inline struct bed_state bed_state(double x, double y, double z, double yaw, double pitch, double roll)
{
	struct bed_state state = {.at = {x, y, z}};
	soil_axes(yaw, pitch, roll, 0, state.axes);
	return state;
}

/* Turns a body about an axis through its centre: 0 .. 2 east, north, up. */
static inline void bed_turn(struct bed_state *state, int axis, double by)
{
	const int a = (axis + 1) % 3, b = (axis + 2) % 3;
	for (int k = 0; k < 3; k++) {
		double *v = state->axes[k], x = v[a], y = v[b];
		v[a] = cos(by) * x - sin(by) * y;
		v[b] = sin(by) * x + cos(by) * y;
	}
}

static inline struct soil_pose bed_pose(const struct soil_shape *shape, const struct bed_state *state)
{
	const double (*axes)[3] = state->axes;
	struct soil_pose pose = {lattice_offset(state->at[0]), lattice_offset(state->at[1]), lattice_offset(state->at[2]), 0, 0, 0, 0};
	if (shape->kind == SOIL_WHEEL) {
		soil_wheel_attitude(axes[1], &pose.yaw, &pose.roll);
		return pose;
	}
	pose.yaw = atan2(axes[0][1], axes[0][0]);
	pose.pitch = asin(fmin(fmax(axes[0][2], -1), 1));
	pose.roll = atan2(axes[1][2], axes[2][2]);
	return pose;
}

/* Returns the motion from one state to another by a host. rotated: rad about east, north, up; of a wheel, its part about the axle counts. */
static inline struct soil_motion bed_motion(const struct soil_shape *shape, const struct bed_state *from, const struct bed_state *to, const double rotated[3])
{
	struct soil_motion motion = {.shape = shape, .from = bed_pose(shape, from), .to = bed_pose(shape, to), .hosted = true};
	const int64_t place[3] = {motion.to.x, motion.to.y, motion.to.z};
	for (int k = 0; k < 3; k++) {
		motion.beyond[k] = to->at[k] - lattice_offset_metres(place[k]);
		motion.rotated[k] = rotated != NULL ? rotated[k] : 0;
		motion.turned += shape->kind == SOIL_WHEEL && rotated != NULL ? rotated[k] * to->axes[1][k] : 0;
	}
	return motion;
}

/* Presses the body. start: height at which the search for a load begins, fixed-point units. */
static inline struct soil_imprint bed_press(struct bed *bed, const struct soil_motion *motion, int32_t start)
{
	const struct soil_laying laying = soil_laying_of(motion->shape, &motion->from, &motion->to, motion->turned, motion->rotated, bed->law.spacing);
	const struct soil_sink press = {.laying = &laying, .soils = bed->laid, .start = start};
	struct soil_imprint out;
	assert_ok(soil_sink_body(&bed->law, &bed->planes, motion, &press, bed->work, &out));
	return out;
}

/* Returns the forces that bed_press would tell. Changes nothing. */
static inline struct soil_forces bed_feel(struct bed *bed, const struct soil_motion *motion, int32_t start)
{
	struct soil_imprint out;
	assert_ok(soil_sink_begin(&bed->law, &bed->planes, motion, start, bed->work));
	soil_sink_find(bed->work, &out);
	return out.forces;
}

static inline struct soil_probed bed_probe(struct bed *bed, const struct soil_motion *motion)
{
	struct soil_probed out;
	assert_ok(soil_probe(&bed->law, &bed->planes, motion, bed->work, &out));
	return out;
}

#endif
