/* Describes a moving shape by whole numbers. The shader computes its lower envelope in a window from them. A mesh has none. */
#ifndef FURROW_SOIL_BODY_H
#define FURROW_SOIL_BODY_H

#include "soil/shape/affine.h"
#include "soil/soil.h"

/* The origin of a window: its first post and its zero height. Heights in the window count from the zero height. */
struct body_frame {
	int64_t x0, y0; /* post */
	double spacing; /* metres */
	int64_t zero;   /* fixed-point units, absolute */
	long double yaw[2]; /* its cosine and sine; read for wheels only */
};

struct body_motion {
	int64_t x0, y0;     /* the window's first post, counted from the anchor: the post south-west of the end pose */
	long double x, y;   /* the start, counted from the anchor, metres */
	long double dx, dy; /* from the start to the end, metres */
	int64_t z, dz;      /* height of the start above the frame's zero, and rise from start to end, fixed-point units */
};

struct body_motion soil_body_motion_of(const struct soil_pose *from, const struct soil_pose *to,
				  const struct body_frame *frame);
/* Computes the motion from `from` to `to`, with the attitude of `to`, relative to the frame. */
void soil_body_of(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to,
	     const struct body_frame *frame, struct body *body);
/* Computes half the size along x and y of the area below the object, metres. */
void soil_body_extent(const struct soil_shape *shape, const struct soil_pose *pose, double extent[2]);
/* Returns the distance from a post to a place along one axis, metres. `place`: 2^-20 m. It is rounded once, at the end. */
long double soil_body_from_post(int64_t place, int64_t post, double spacing);
/* Computes the three half-axes of a box in this attitude. */
void soil_body_axes(const double size[3], double yaw, double pitch, double roll, double axes[3][3]);
/* Returns the form that shaders compute a shape as in a pose: its kind, but SOIL_CYLINDER for a wheel whose axle is not level. */
enum soil_shape_kind soil_kind_in(const struct soil_shape *shape, const struct soil_pose *pose);
/* Returns the radius of a wheel to the end of its grousers, metres. */
double soil_body_wheel_radius(const struct soil_shape *shape);
/* The most that a motion may rise or fall, fixed-point units. Beyond it the object is set down anew, without a motion. */
#define BODY_RISE_MAX (1 << 29)

#endif
