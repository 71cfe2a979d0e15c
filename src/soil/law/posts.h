/*
 * The posts that a body may touch, an array for each number. A contact or a probe gathers them once, and each evaluation of the law reads them. Posts
 * come row by row. Arrays are filled to a multiple of POSTS_LANES; the posts beyond `count` bear nothing and have finite numbers.
 */
#ifndef FURROW_SOIL_POSTS_H
#define FURROW_SOIL_POSTS_H

#include "soil/law/form.h"

#define POSTS_LANES 16

/* What an evaluation reads. */
#define POSTS_LAW_WHOLES_EACH(EACH) \
	EACH(ground)    /* height of the undisturbed surface above the body's centre, fixed-point units */ \
	EACH(surface)   /* of the surface as it is; fixed-point units above the centre */ \
	EACH(deposited) EACH(shear) /* of the planes, before; deposited: of the top layer (memory.h) */ \
	EACH(floor)     /* below a loose layer: its largest sinkage (memory.h), fixed-point units */
#define POSTS_LAW_REALS_EACH(EACH) \
	EACH(x) EACH(y)             /* m, in the body's frame */ \
	EACH(rise_x) EACH(rise_y)   /* of the base, along the frame's axes */ \
	EACH(up) EACH(by_up)        /* z of the base's normal, and its inverse */ \
	EACH(was)                   /* m along the normal: the largest sinkage so far */ \
	EACH(shear_x) EACH(shear_y) /* mobilised before, along the frame's axes */ \
	EACH(dug)                   /* m: by slip, so far */ \
	EACH(over)                  /* 1: the body is above the post in its end pose; 0: beside */ \
	EACH(own)                   /* face.h */ \
	EACH(height) EACH(slope_x) EACH(slope_y) /* of the lower envelope at the post, m above the centre */ \
	EACH(above)                 /* m: how much lower grousers are there, 0 or less */ \
	EACH(lowered)               /* m: how much lower the body was there during its motion */ \
	EACH(entered)               /* raster: how many motions ago the body came above the post */ \
	EACH(halfway) EACH(begun)   /* raster: how much higher the body was there halfway through its motion, and at its start, m */ \
	EACH(print)                 /* m: height of the lower envelope where the post was at the motion's start */ \
	EACH(share) EACH(middle_x) EACH(middle_y) /* the part of the post's cell that the body covers: share of a cell's area, its middle from the post */ \
	EACH(half_line)             /* box: half of a line across that part, m */ \
	EACH(edge_long) EACH(edge_x) EACH(edge_y) EACH(other_long) EACH(other_x) EACH(other_y) /* box: edges from which its walls rise: length, posts; middle, m in the frame */ \
	EACH(side_behind) EACH(side_ahead) EACH(side_right) EACH(side_left) /* 1: the body's side ends that part there */ \
	EACH(heap)                  /* m: of the ground above where a body that slides counts its depth from (faces/ahead.c); below 0: so far below */ \
	EACH(room)                  /* m: the body touches the cell if it is raised by less */ \
	EACH(k) EACH(n) EACH(elastic) EACH(by_elastic) EACH(cohesion) EACH(tan_phi) EACH(modulus) EACH(by_modulus) EACH(damping) EACH(whole) EACH(loose_thick) EACH(under) /* struct stress_soil; loose_thick: its `loose` */
/* What an evaluation of ground with layers reads beside these (layers.h). */
#define POSTS_LAYER_REALS_EACH(EACH) \
	EACH(thick)                 /* m along the normal: how thick the post's soil is, or its floor's; LAYER_NONE: it lies over no other */ \
	EACH(bulb) \
	EACH(base_k) EACH(base_n) EACH(base_elastic) EACH(base_cohesion) EACH(base_tan_phi) EACH(base_modulus) EACH(base_damping) /* of the soil below */
/* And what it does not. */
#define POSTS_WHOLES_EACH(EACH) \
	POSTS_LAW_WHOLES_EACH(EACH) \
	EACH(index)     /* of the post in the planes */ \
	EACH(sinkage) EACH(digs) /* of the planes, before; sinkage: of the top layer */ \
	EACH(settled) EACH(loose) /* the loose layer, before (memory.h); settled: of the plane */ \
	EACH(density) /* of the plane, before */ \
	EACH(west) EACH(east) EACH(south) EACH(north) EACH(base) /* of the base, as in the planes */
#define POSTS_REALS_EACH(EACH) \
	POSTS_LAW_REALS_EACH(EACH) \
	POSTS_LAYER_REALS_EACH(EACH) \
	EACH(base_k_c) EACH(base_k_phi) \
	EACH(left)                  /* of a layer below a loose one: what is left of it below the floor, m along the normal; of posts with such */ \
	EACH(swept)                 /* 1: the body was above the post during its motion */ \
	EACH(bars)                  /* m above the centre: how low grousers were during the motion of a drum that counts for them; FINE_NONE: none was there */ \
	EACH(compact)               /* how dense the soil is before any pass, 0 .. 1 */ \
	EACH(eases)                 /* by how much less the top layer bears than the soil; 1: it is not loose */ \
	EACH(k_c) EACH(k_phi)       /* of the soil, for soil_posts_width */

struct soil_posts {
	size_t count, capacity;
	bool floored; /* some posts have a loose layer on a floor */
	bool layered; /* the law has layers. Else the arrays of layers are not set */
	void *memory;
#define POSTS_WHOLE(name) int32_t *name;
#define POSTS_REAL(name) float *name;
	POSTS_WHOLES_EACH(POSTS_WHOLE)
	POSTS_REALS_EACH(POSTS_REAL)
#undef POSTS_WHOLE
#undef POSTS_REAL
};

/* Makes room for so many posts, at least. Keeps nothing. STATUS_MEMORY otherwise. soil_posts_finish frees it; zero the struct before first use. */
enum status soil_posts_need(struct soil_posts *posts, size_t count) FURROW_CHECKED;
void soil_posts_finish(struct soil_posts *posts);
size_t soil_posts_bytes(const struct soil_posts *posts); /* of its arrays */

/* Returns the number of posts, rounded up to whole blocks. */
SOIL_INLINED size_t soil_posts_end(const struct soil_posts *posts)
{
	return (posts->count + POSTS_LANES - 1) / POSTS_LANES * POSTS_LANES;
}

/* Gathers the posts that the body may touch if its centre is not lower than `raised` fixed-point units above motion->to. Gathers also those above whose
 * ground it is by at most `above` m. With `above` 0 it leaves out others that bear nothing. by_width: 1 / width of the contact patch, 1/m; 0: not
 * known. planes: of a rectangle that has all posts below the body with their neighbours. posts->capacity: at least soil_posts_below's posts. Does not
 * set `k`, which soil_posts_width does. */
void soil_posts_gather(const struct soil_law *law, const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form,
		       int32_t raised, double above, double by_width, struct soil_posts *posts);
/* Sets `k` for a contact patch of this width: 1/m. bulb: of layers, m. */
void soil_posts_width(float by_width, float bulb, struct soil_posts *posts);
/* Returns the posts that may be below a body during its motion. */
struct post_rect soil_posts_below(const struct soil_law *law, const struct soil_motion *motion);

#endif
