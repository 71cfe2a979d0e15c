/*
 * kinematic: a contact of the models none, box, sumner and slippage over a window in host memory. It has the same bits as their passes on the GPU.
 * The body follows its path, whatever the soil does. Its lower envelope lowers the ground. What the body displaces is lost, or carried to posts
 * around, where soil/laying lays it and soil/sliding lets it slide.
 *
 * Pure: nothing is allocated, and nothing is kept between calls. Windows that share no post may be computed on several threads.
 */
#ifndef FURROW_SOIL_KINEMATIC_H
#define FURROW_SOIL_KINEMATIC_H

#include "soil/soil.h"

/* What becomes of the displaced soil. All zeros: it is lost (model none). */
struct soil_kinematic {
	int radius, repetitions;      /* model box: the trail is smoothed over 1 to 4 posts around, 1 to 8 times; 0: not */
	bool carries;                 /* models sumner, slippage: displaced soil is carried; what is not is compacted */
	uint32_t kept[SOIL_CLASSES];  /* by class of soil: the share that is carried, 2^-31 */
	double spacing;               /* m between posts */
	int32_t reference;            /* m: heights of the base count from there */
};

/* A body's contact: it moves straight from `from` to `to` with the attitude of `to`. */
struct soil_kinematic_contact {
	const struct soil_shape *shape;
	struct soil_pose from, to;
	double turned; /* wheel: rad that it turns forwards about its axle */
};

/* Sums over the written posts of all contacts so far. */
struct soil_kinematic_tally {
	int64_t compacted; /* fixed-point units */
	uint64_t refused;  /* posts that would have left the range of an offset */
};

/* Prepare the model sumner by its soils' `compression`, and slippage, which carries all. count: 1 to SOIL_CLASSES. */
void soil_kinematic_sumner(struct soil_kinematic *kinematic, const struct soil_numbers *soils, int count);
void soil_kinematic_slippage(struct soil_kinematic *kinematic);

/* Returns the bytes of scratch memory that a contact needs at most, over a window of so many posts. */
size_t soil_kinematic_room(const struct soil_kinematic *kinematic, const struct soil_kinematic_contact *contact, size_t width, size_t height);

/*
 * Computes a contact over a window.
 *
 * planes: base, offset and contact must be there; classes and disturbance may be. Changes offset, and all of contact: SOIL_LOWERED, SOIL_HELD,
 * SOIL_NEAR, SOIL_NO_GROUND. Near: the body was less than two spacings above the post. Posts beyond the world have no ground.
 * Posts that are not `written` may change. They belong to another window.
 * Changes disturbance too, unless soil is carried: then call soil_kinematic_disturb after sliding.
 * With `radius` the window must have posts around the written ones: as many as the radius times the repetitions. Their results mean nothing.
 * carried: a plane with the same rows: fixed-point units that each post gives away, all of it written; NULL if nothing is carried.
 * scratch: soil_kinematic_room() bytes, aligned to 8.
 */
void soil_kinematic_run(const struct soil_kinematic *kinematic, const struct soil_kinematic_contact *contact, struct soil_planes *planes,
			struct post_rect written, int32_t *carried, void *scratch, struct soil_kinematic_tally *tally);

/* Changes the disturbance of lowered posts, by contact and offset. posts: those below the body (soil_shadow), or more; within the planes. */
void soil_kinematic_disturb(const struct soil_planes *planes, struct post_rect posts);

/* Marks that fade, as base/plane.h has them. */
struct soil_mark {
	int32_t now, heals;   /* the time, and what the darkest disturbance takes to heal */
	int32_t risen, grown; /* when what a contact bends now has risen, and what it tears now has grown */
};
/* Planes of marks that fade, with the rows of a struct soil_planes; NULL: not kept. */
struct soil_marks {
	int32_t *healed, *risen, *grown;
};
/* Marks lowered posts in those that there are. Reads contact and offset. posts: as above. */
void soil_kinematic_mark(const struct soil_planes *planes, const struct soil_marks *marks, struct post_rect posts, const struct soil_mark *mark);

/* Marks the posts that a body at rest in a pose holds: adds SOIL_HELD to planes->contact. It does not rest on soil above its lower envelope, which
 * lies against its side. Reads base, offset, contact. scratch: as above. */
void soil_kinematic_hold(const struct soil_kinematic *kinematic, const struct soil_shape *shape, const struct soil_pose *pose,
			 struct soil_planes *planes, void *scratch);
/* The same, and notes how high soil may bring posts below the body: lowers `highest`, a plane of the planes' posts (soil/sliding/roofs.h). Returns true if a
 * post has a roof. mirrored: the mesh of a body that is a mesh, with its z negated; NULL: no ground is above such a body. scratch: twice as many bytes. */
bool soil_kinematic_roof(const struct soil_kinematic *kinematic, const struct soil_shape *shape, const struct soil_mesh *mirrored, const struct soil_pose *pose,
			 struct soil_planes *planes, int32_t *highest, void *scratch);
/* Returns the pose of a body upside down that is at this pose: its upper side is a lower one. A mesh is then soil_kinematic_mirror's. Pure. */
struct soil_pose soil_upside_down(const struct soil_pose *pose);
/* Makes a mesh upside down: with its z negated. The caller frees mirrored->vertices with mem_free; the rest is the mesh's. STATUS_MEMORY: it has no vertices. */
enum status soil_kinematic_mirror(const struct soil_mesh *mesh, struct soil_mesh *mirrored) FURROW_CHECKED;

#endif
