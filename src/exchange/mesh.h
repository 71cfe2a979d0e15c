/* Inside exchange: a surface as triangles, row by row from the south, and the writers of its formats. */
#ifndef FURROW_EXCHANGE_MESH_H
#define FURROW_EXCHANGE_MESH_H

#include <math.h>
#include <stdio.h>

#include "exchange/exchange.h"

/* A row of posts with its neighbours. Each row has one more post on both sides; NaN: a hole, or beyond the window's terrain. */
struct exchange_row {
	const double *heights[4]; /* metres: of the row to the south, this one, and two to the north; [x + 1] is post x */
	int64_t y, width, rows;   /* this row; the window's size in posts */
};
/* Returns true if a triangle has post x of this row (above 0: of the row to the north). */
bool exchange_row_used(const struct exchange_row *row, int64_t x, int above);
/* Gives the triangles of the cell to the north-east of post x: corners 0 to 3 are south-west, south-east, north-west, north-east.
 * Counter-clockwise from above. Returns their number, 0 to 2. */
int exchange_row_triangles(const struct exchange_row *row, int64_t x, int triangles[2][3]);
/* Gives the upward normal of a post that is no hole: east, north, up. */
void exchange_row_normal(const struct exchange_row *row, int64_t x, double spacing, double normal[3]);

typedef enum status (*exchange_row_fn)(void *user, const struct exchange_row *row);
struct exchange_surface {
	const struct exchange_mesh_params *params;
	int64_t width, rows; /* posts */
	double spacing;
	int64_t done, total; /* rows read so far, and in all passes */
	uint64_t *first;     /* number of the first vertex of each row, and behind it of all */
	uint64_t triangles;
	double origin[3], low[3], high[3];
	bool y_up;
	char name[256]; /* of the terrain: UTF-8 without control characters */
	FILE *file;
};
/* Calls `fn` for each row, from the south. */
enum status exchange_surface_each(struct exchange_surface *surface, exchange_row_fn fn, void *user) FURROW_CHECKED;
/* The position of a post, in metres from the origin: east, north, up; each is exactly a float. */
void exchange_surface_position(const struct exchange_surface *surface, const struct exchange_row *row, int64_t x, double out[3]);
/* Calls `fn` with each triangle: numbers of its vertices, and their places in this and the next row (0 to 3 as in
 * exchange_row_triangles). */
typedef enum status (*exchange_triangle_fn)(void *user, const struct exchange_row *row, int64_t x, const int corners[3], const uint64_t vertices[3]);
enum status exchange_surface_triangles(struct exchange_surface *surface, exchange_triangle_fn fn, void *user) FURROW_CHECKED;
/* Writes to the file. STATUS_FAILED: it cannot. */
enum status exchange_surface_put(struct exchange_surface *surface, const void *bytes, size_t size) FURROW_CHECKED;

/* East, north, up as the mesh has them: turned, so that y is up and z south, or as they are. */
void exchange_surface_turn(const struct exchange_surface *surface, const double from[3], double to[3]);

/* The picture that lies over a mesh, a PNG in memory, and where: in posts from the window's first. */
#define EXCHANGE_TEXTURE_SIDE 2049 /* pixels at most: 2^n + 1 posts are usual */
struct exchange_texture {
	char *png;
	size_t bytes;
	double west, south, width, height;
};
/* Makes the picture. On failure `out` is all zero. */
enum status exchange_texture_create(const struct exchange_mesh_params *params, struct exchange_texture *out) FURROW_CHECKED;
/* Where a post is in the picture: 0 to 1 from its west and from its south edge. */
void exchange_texture_place(const struct exchange_texture *texture, int64_t x, int64_t y, double out[2]);
void exchange_texture_finish(struct exchange_texture *texture); /* may be all zero */

struct exchange_mesh_format {
	const char *ending;
	bool y_up; /* if params->up does not say another */
	int passes; /* over the rows, beside the first one that counts */
	double (*bytes)(double vertices, double triangles); /* of the file, or a few more */
	enum status (*write)(struct exchange_surface *surface);
};
extern const struct exchange_mesh_format exchange_obj, exchange_glb, exchange_stl;

#endif
