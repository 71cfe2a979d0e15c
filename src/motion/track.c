/*
 * Tracks: the way of a body along its path, from knot to knot in straight segments. Path samples are one post of way apart.
 */
#include "motion/motion.h"

#include <assert.h>
#include <math.h>

struct knot {
	struct track_point at; /* x, y in metres from the track's origin */
	double length;         /* of the path up to here, m; with attitudes, turns add to it */
};

struct track {
	struct knot *knots; /* at least 1; in a loop the first is repeated at the end */
	size_t count;
	int64_t origin_x, origin_y; /* the first point, 2^-20 m */
	double post, speed, length; /* m between path samples; m/s; m of the whole path */
	int64_t lap; /* number of path samples in one lap; loops only */
	int64_t samples; /* INT64_MAX for a loop */
	double delay; /* s before it begins; 0 if timed, since the times of the knots have it */
	bool loop, timed;
	bool turns; /* evenly between knots; otherwise at once at each */
};

static double turn(double from, double to)
{
	return remainder(to - from, 2 * M_PI);
}

/* Counts the path samples. */
static int64_t count_samples(const struct track *track)
{
	if (track->loop)
		return INT64_MAX;
	double posts = track->length / track->post;
	int64_t whole = (int64_t)floor(posts);
	return whole + 1 + (posts - (double)whole > 1e-9);
}

static double distance(const struct track_point *a, const struct track_point *b, bool attitude, double reach)
{
	double length = sqrt((b->x - a->x) * (b->x - a->x) + (b->y - a->y) * (b->y - a->y) +
			     (b->z - a->z) * (b->z - a->z));
	if (attitude)
		length += reach * (fabs(turn(a->yaw, b->yaw)) + fabs(turn(a->pitch, b->pitch)) +
				   fabs(turn(a->roll, b->roll)));
	return length;
}

/* Without attitudes, a body faces along the segment that begins at the knot. Where it is at rest it faces the way it went, or at the beginning
 * the way it will go. */
static void face_along(struct track *track)
{
	struct knot *knots = track->knots;
	size_t still = 0; /* so many knots at the beginning are at one place */
	for (size_t i = 0; i + 1 < track->count; i++) {
		const double dx = knots[i + 1].at.x - knots[i].at.x, dy = knots[i + 1].at.y - knots[i].at.y;
		const bool moves = dx != 0 || dy != 0;
		knots[i].at.yaw = moves ? atan2(dy, dx) : i > 0 ? knots[i - 1].at.yaw : 0;
		for (; moves && still < i; still++)
			knots[still].at.yaw = knots[i].at.yaw;
		still = moves ? track->count : still;
	}
	if (track->count > 1)
		knots[track->count - 1].at.yaw = knots[track->count - 2].at.yaw;
}

/* Turns a body against its way: yaw, pitch, roll. */
static void turn_against(struct track *track, const double attitude[3])
{
	for (size_t i = 0; i < track->count; i++) {
		struct track_point *at = &track->knots[i].at;
		at->yaw += attitude[0];
		at->pitch = attitude[1];
		at->roll = attitude[2];
	}
}

enum status motion_track_create(const struct scene_path *path, double post, double turn_reach, struct track **out)
{
	assert(path->count >= 1);
	struct track *track = mem_calloc(1, sizeof *track);
	struct knot *knots = mem_calloc(path->count + 1, sizeof *knots);
	if (track == NULL || knots == NULL) {
		mem_free_all(track, knots);
		return fail_memory("a path");
	}
	track->knots = knots;
	track->post = post;
	track->speed = path->speed;
	track->timed = path->timed;
	track->turns = path->timed && path->has_attitude && !path->cornered;
	track->delay = path->timed ? 0 : path->delay;
	track->origin_x = lattice_offset(path->points[0].x);
	track->origin_y = lattice_offset(path->points[0].y);
	for (size_t i = 0; i < path->count; i++) {
		const struct scene_waypoint *from = &path->points[i];
		struct track_point point = {
			.time = from->t + path->delay,
			.x = lattice_offset_metres(lattice_offset(from->x) - track->origin_x),
			.y = lattice_offset_metres(lattice_offset(from->y) - track->origin_y),
			.z = path->has_z ? from->z : 0,
		};
		if (path->has_attitude) {
			point.yaw = from->yaw;
			point.pitch = from->pitch;
			point.roll = from->roll;
		}
		double length = 0;
		if (track->count > 0) {
			struct knot *before = &knots[track->count - 1];
			length = before->length + distance(&before->at, &point, path->has_attitude, turn_reach);
			/* A path without times does not pause: skip a point that is where the last one is. */
			if (!path->timed && length == before->length)
				continue;
		}
		knots[track->count++] = (struct knot){point, length};
	}
	bool closed = path->loop && track->count > 1;
	if (closed) {
		struct knot *last = &knots[track->count - 1];
		double length = last->length + distance(&last->at, &knots[0].at, path->has_attitude, turn_reach);
		if (length > last->length) {
			knots[track->count] = (struct knot){knots[0].at, length};
			track->count++;
		}
	}
	track->length = knots[track->count - 1].length;
	track->loop = closed && track->length > 0;
	if (!path->has_attitude) {
		face_along(track);
		turn_against(track, path->attitude);
	}
	if (!track->timed)
		for (size_t i = 0; i < track->count; i++)
			knots[i].at.time = track->delay + (track->speed > 0 ? knots[i].length / track->speed : 0);
	if (track->loop)
		track->lap = (int64_t)ceil(track->length / post * (1 - 1e-12));
	track->samples = count_samples(track);
	*out = track;
	return STATUS_OK;
}

void motion_track_destroy(struct track *track)
{
	if (track == NULL)
		return;
	mem_free_all(track->knots, track);
}

int64_t motion_track_samples(const struct track *track)
{
	return track->samples;
}

double motion_track_fastest(const struct track *track)
{
	double fastest = track->timed ? 0 : track->speed;
	for (size_t i = 1; track->timed && i < track->count; i++) {
		const struct track_point *a = &track->knots[i - 1].at, *b = &track->knots[i].at;
		if (b->time > a->time)
			fastest = fmax(fastest, hypot(b->x - a->x, b->y - a->y) / (b->time - a->time));
	}
	return fastest;
}

/* Returns k so that `key` lies between knots k and k + 1. key: a time in s if by_time, otherwise a length in m. */
static size_t find(const struct track *track, double key, bool by_time)
{
	size_t low = 0, high = track->count - 1;
	while (high - low > 1) {
		size_t middle = (low + high) / 2;
		double at = by_time ? track->knots[middle].at.time : track->knots[middle].length;
		/* Where a timed path pauses, several knots have the same length. Then the first of them counts: the time of arrival. */
		if (by_time || !track->timed ? at <= key : at < key)
			low = middle;
		else
			high = middle;
	}
	return low;
}

static void between(const struct track *track, size_t k, double share, struct track_point *point)
{
	const struct track_point *a = &track->knots[k].at, *b = &track->knots[k + 1].at;
	*point = *a;
	point->time += share * (b->time - a->time);
	point->x += share * (b->x - a->x);
	point->y += share * (b->y - a->y);
	point->z += share * (b->z - a->z);
	if (track->turns) { /* others keep the attitude of the segment */
		point->yaw += share * turn(a->yaw, b->yaw);
		point->pitch += share * turn(a->pitch, b->pitch);
		point->roll += share * turn(a->roll, b->roll);
	}
}

/* m of the path at a time. Of a timed path alone. */
static double length_at(const struct track *track, double time)
{
	const struct knot *knots = track->knots;
	if (time <= knots[0].at.time || track->count == 1)
		return 0;
	if (time >= knots[track->count - 1].at.time)
		return track->length;
	const size_t k = find(track, time, true);
	const double begin = knots[k].at.time, end = knots[k + 1].at.time;
	return knots[k].length + (end > begin ? (time - begin) / (end - begin) : 1) * (knots[k + 1].length - knots[k].length);
}

double motion_track_most(const struct track *track, double seconds)
{
	double most = track->timed ? 0 : track->speed * seconds;
	/* The way of an interval is longest where it begins or ends at a knot. */
	for (size_t k = 0; track->timed && k < track->count; k++) {
		const double time = track->knots[k].at.time;
		most = fmax(most, fmax(length_at(track, time + seconds) - track->knots[k].length, track->knots[k].length - length_at(track, time - seconds)));
	}
	return (track->loop ? most : fmin(most, track->length)) / track->post + 1;
}

/* Converts a point that is given from the track's origin to one that is given from the world's origin. */
static void place(const struct track *track, struct track_point *point)
{
	point->qx = track->origin_x + lattice_offset(point->x);
	point->qy = track->origin_y + lattice_offset(point->y);
	point->x = lattice_offset_metres(point->qx);
	point->y = lattice_offset_metres(point->qy);
}

static void at_length(const struct track *track, double length, struct track_point *point)
{
	if (track->count == 1) {
		*point = track->knots[0].at;
		return;
	}
	size_t k = find(track, length, false);
	double begin = track->knots[k].length, end = track->knots[k + 1].length;
	double share = end > begin ? (length - begin) / (end - begin) : 0;
	between(track, k, share < 1 ? share : 1, point);
	if (share >= 1 && track->timed)
		*point = track->knots[k + 1].at;
}

static double sample_length(const struct track *track, int64_t index, int64_t *lap)
{
	*lap = track->loop ? index / track->lap : 0;
	int64_t within = index - *lap * track->lap;
	if (!track->loop && index == motion_track_samples(track) - 1)
		return track->length;
	return (double)within * track->post;
}

void motion_track_sample(const struct track *track, int64_t index, struct track_point *point)
{
	int64_t lap;
	at_length(track, sample_length(track, index, &lap), point);
	point->time = motion_track_sample_time(track, index);
	place(track, point);
}

double motion_track_sample_time(const struct track *track, int64_t index)
{
	int64_t lap;
	double length = sample_length(track, index, &lap);
	if (!track->timed)
		return track->delay + (track->speed > 0 ? ((double)lap * track->length + length) / track->speed : 0);
	struct track_point point;
	at_length(track, length, &point);
	return point.time;
}

static bool is_within(const struct track_point *point, double width, double height)
{
	return point->x >= 0 && point->y >= 0 && point->x <= width && point->y <= height;
}

static bool sample_within(const struct track *track, int64_t index, double width, double height)
{
	struct track_point point;
	motion_track_sample(track, index, &point);
	return is_within(&point, width, height);
}

/* Returns the first path sample of first .. last that is outside the world; -1: none. All samples lie on one straight line. So once
 * the line has left the world, it does not come back. */
static int64_t leaves_line(const struct track *track, int64_t first, int64_t last, double width, double height)
{
	if (first > last || !sample_within(track, first, width, height))
		return first > last ? -1 : first;
	if (sample_within(track, last, width, height))
		return -1;
	while (last - first > 1) {
		int64_t middle = first + (last - first) / 2;
		if (sample_within(track, middle, width, height))
			first = middle;
		else
			last = middle;
	}
	return last;
}

int64_t motion_track_leaves(const struct track *track, double width, double height)
{
	int64_t all = track->loop ? track->lap : motion_track_samples(track);
	bool was_within = true;
	for (size_t k = 0; k < track->count; k++) {
		struct track_point knot = track->knots[k].at;
		place(track, &knot);
		bool within = is_within(&knot, width, height);
		if (k > 0 && !(within && was_within)) {
			int64_t first = (int64_t)ceil(track->knots[k - 1].length / track->post);
			int64_t last = (int64_t)floor(track->knots[k].length / track->post);
			int64_t found = leaves_line(track, first, last < all ? last : all - 1, width, height);
			if (found >= 0)
				return found;
		}
		was_within = within;
	}
	/* The last path sample is at the end of the path. Its distance from the sample before may be less than a post. */
	return was_within || track->loop || sample_within(track, all - 1, width, height) ? -1 : all - 1;
}

void motion_track_at(const struct track *track, double time, struct track_point *point)
{
	if (!track->timed) {
		double length = time > track->delay ? (time - track->delay) * track->speed : 0;
		if (track->loop)
			length = fmod(length, track->length);
		at_length(track, length < track->length ? length : track->length, point);
	} else if (track->count == 1 || time <= track->knots[0].at.time) {
		*point = track->knots[0].at;
	} else {
		size_t k = find(track, time, true);
		double begin = track->knots[k].at.time, end = track->knots[k + 1].at.time;
		double share = end > begin ? (time - begin) / (end - begin) : 1;
		between(track, k, share < 1 ? share : 1, point);
	}
	point->time = time;
	place(track, point);
}

size_t motion_track_corners(const struct track *track)
{
	return track->count + 1;
}

size_t motion_track_way(const struct track *track, double time, double (*places)[2])
{
	size_t count = 0;
	for (; count < track->count && (count == 0 || track->knots[count].at.time <= time); count++) {
		struct track_point knot = track->knots[count].at;
		place(track, &knot);
		places[count][0] = knot.x;
		places[count][1] = knot.y;
	}
	if (count < track->count) {
		struct track_point now;
		motion_track_at(track, time, &now);
		places[count][0] = now.x;
		places[count][1] = now.y;
		count++;
	}
	return count;
}
