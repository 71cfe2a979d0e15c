/* The contact at posts of a row, and the smoothing of a trail. Parts of a contact: kinematic.c calls them. Pure. */
#ifndef FURROW_SOIL_CONTACT_H
#define FURROW_SOIL_CONTACT_H

#include "soil/kinematic/kinematic.h"

/* Posts of a row. */
struct contact_row {
	int32_t count;
	const int32_t *base, *under, *rest;
	int32_t *offset;      /* changed */
	uint8_t *contact;     /* written */
	const uint8_t *classes; /* NULL: all are of class 0 */
	int32_t *carried;     /* written; NULL: nothing is carried */
	int64_t zero;         /* height from which under and rest count, fixed-point units above the store's reference */
	int32_t near;         /* fixed-point units: a body less than this above the post is near */
	int32_t written[2];   /* the posts that are counted: first, one behind the last */
};

/* Lowers the posts of a row to the body, where it is lower. kept: as in struct soil_kinematic; read if soil is carried. */
void soil_contact_row(const struct contact_row *row, const uint32_t kept[SOIL_CLASSES], struct soil_kinematic_tally *tally);
/* Adds SOIL_HELD where a body at rest touches the ground. Reads base, offset, rest, zero. */
void soil_hold_row(const struct contact_row *row);
/* Changes the disturbance of posts that were lowered. */
/* The same for disturbance that heals, and for a plane whose marks are all gone at `until`. heals: quarter seconds of the darkest disturbance. */
void soil_heal_row(int32_t count, const uint8_t *contact, const int32_t *offset, int32_t now, int32_t heals, int32_t *healed);
void soil_mark_row(int32_t count, const uint8_t *contact, int32_t until, int32_t *plane);
void soil_disturb_row(int32_t count, const uint8_t *contact, const int32_t *offset, uint8_t *disturbance);

/* Posts, counted from the planes' first one: the first, and one behind the last. */
struct smooth_posts {
	int32_t x0, y0, x1, y1;
};
/* Returns the bytes of scratch memory that soil_smooth needs. width, height: of the trail, posts. */
size_t soil_smooth_room(size_t width, size_t height, int radius);
/* Smooths the offsets of the trail, `repetitions` times. trail: posts that the body may have lowered, and `radius` posts around them. Posts beyond
 * the planes take no part in a mean. Reads contact, changes offset. scratch: aligned to 8. */
void soil_smooth(const struct soil_kinematic *kinematic, const struct soil_planes *planes, struct smooth_posts trail, void *scratch);

#endif
