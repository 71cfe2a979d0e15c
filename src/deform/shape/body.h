/* A moving object as whole numbers for the shader: the numbers of a contact that a window needs. */
#ifndef FURROW_DEFORM_BODY_H
#define FURROW_DEFORM_BODY_H

#include "deform/shape/affine.h"
#include "deform/deform.h"

/* A window's first post and its zero height. */
struct body_frame {
	int64_t x0, y0; /* post */
	double spacing; /* metres */
	int64_t zero;   /* fixed-point units, absolute */
};

struct body_motion {
	int64_t x0, y0;     /* the window's first post, counted from the anchor: the post south-west of the end pose */
	long double x, y;   /* the start, counted from the anchor, metres */
	long double dx, dy; /* from the start to the end, metres */
	int64_t z, dz;      /* start above the frame's zero, and rise, fixed-point units */
};

struct body_motion deform_body_motion_of(const struct deform_pose *from, const struct deform_pose *to,
				  const struct body_frame *frame);
/* Computes the motion from `from` to `to`, with the attitude of `to`, relative to the frame. */
void deform_body_of(const struct deform_shape *shape, const struct deform_pose *from, const struct deform_pose *to,
	     const struct body_frame *frame, struct body *body);
/* Computes half the width of the object's shadow along x and y, metres. */
void deform_body_extent(const struct deform_shape *shape, const struct deform_pose *pose, double extent[2]);
/* Returns the distance from a post to a place on the lattice, metres. It is rounded once, at the end. */
long double deform_body_from_post(int64_t place, int64_t post, double spacing);
/* Computes the three half-axes of a box in this attitude. */
void deform_body_axes(const double size[3], double yaw, double pitch, double roll, double axes[3][3]);
/* Returns the radius of a wheel to the end of its grousers, metres. */
double deform_body_wheel_radius(const struct deform_shape *shape);
/* A motion that rises or falls by more than this is a new contact, without motion; fixed-point units. */
#define BODY_RISE_MAX (1 << 29)

#endif
