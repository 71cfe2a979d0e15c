/* An object in motion as whole numbers for the shader: what a window needs of a contact. */
#ifndef FURROW_DEFORM_BODY_H
#define FURROW_DEFORM_BODY_H

#include "deform/shape/affine.h"
#include "deform/deform.h"

/* Where a window's first post lies, and its zero height. */
struct body_frame {
	int64_t x0, y0; /* post */
	double spacing; /* metres */
	int64_t zero;   /* fixed-point units, absolute */
};

struct body_motion {
	int64_t x0, y0;     /* the window's first post from the anchor: the post south-west of the end */
	long double x, y;   /* of the start, from the anchor, metres */
	long double dx, dy; /* to the end */
	int64_t z, dz;      /* fixed-point units: start above the frame's zero, rise */
};

struct body_motion deform_body_motion_of(const struct deform_pose *from, const struct deform_pose *to,
				  const struct body_frame *frame);
/* The motion from `from` to `to` (its attitude), seen from the frame. */
void deform_body_of(const struct deform_shape *shape, const struct deform_pose *from, const struct deform_pose *to,
	     const struct body_frame *frame, struct body *body);
/* Half the width of its shadow along x and y, metres. */
void deform_body_extent(const struct deform_shape *shape, const struct deform_pose *pose, double extent[2]);
/* Metres from a post of the lattice to a place on it: exact but for its last rounding, wherever that is. */
long double deform_body_from_post(int64_t place, int64_t post, double spacing);
/* The three half-axes of a box in this attitude. */
void deform_body_axes(const double size[3], double yaw, double pitch, double roll, double axes[3][3]);
/* To the end of its grousers. */
double deform_body_wheel_radius(const struct deform_shape *shape);
/* A rise beyond which a contact counts as a new contact, fixed-point units. */
#define BODY_RISE_MAX (1 << 29)

#endif
