/*
 * Draws moving triangles over the posts of a patch, in doubles. Each post keeps the lowest height. shape/mesh.c and shape/grousers.c draw
 * the same for the GPU.
 *
 * A post that is back in the triangle's motion by a share of it sees the triangle there. So the shares at which a post is below the triangle
 * are those of a segment, cut by the triangle's three edges. Along it the height is linear: it is lowest at an end.
 */
#include "deform/probe/low.h"

#include "deform/internal.h"
#include "soil/shape/bars.h"
#include "soil/shape/body.h"

#define BESIDE 1e-9   /* m: a post that lies beside an edge by less is below both triangles of the edge */
#define STEEPEST 4096.0 /* a steeper triangle counts as upright: the triangles beside it have its edges */

/* Posts that are drawn. Their first one is so far from the body's centre, m to the east and to the north. */
struct raster {
	struct probe_low low;
	double spacing, corner[2];
	size_t first, columns, rows;
};

/* A triangle at the end of its motion, m from the body's centre. */
struct moving {
	double edges[3][3]; /* above 0 inside: edge[0] + edge[1] x + edge[2] y, m */
	double plane[3];    /* the height, as a sum like those of the edges, m */
	double low, high;   /* m: of its vertices. No height is beyond these */
	double way[3];
	bool resting;
};

/* Returns false if the triangle has no area from above. */
static bool moving_of(const double at[3][3], const double way[3], bool resting, struct moving *m)
{
	const double px = at[1][0] - at[0][0], py = at[1][1] - at[0][1], qx = at[2][0] - at[0][0], qy = at[2][1] - at[0][1];
	const double area = px * qy - py * qx, sign = area < 0 ? -1 : 1;
	if (area == 0)
		return false;
	for (int k = 0; k < 3; k++) {
		const double *a = at[k], *b = at[(k + 1) % 3], x = b[0] - a[0], y = b[1] - a[1], by = sign / sqrt(probe_most(x * x + y * y, 1e-30));
		m->edges[k][1] = -y * by;
		m->edges[k][2] = x * by;
		m->edges[k][0] = -m->edges[k][1] * a[0] - m->edges[k][2] * a[1];
		m->way[k] = way[k];
	}
	const double pz = at[1][2] - at[0][2], qz = at[2][2] - at[0][2];
	m->plane[1] = (pz * qy - qz * py) / area;
	m->plane[2] = (qz * px - pz * qx) / area;
	if (!(probe_most(fabs(m->plane[1]), fabs(m->plane[2])) < STEEPEST))
		return false;
	m->low = probe_least(at[0][2], probe_least(at[1][2], at[2][2]));
	m->high = probe_most(at[0][2], probe_most(at[1][2], at[2][2]));
	m->plane[0] = at[0][2] - m->plane[1] * at[0][0] - m->plane[2] * at[0][1];
	m->resting = resting;
	return true;
}

static double along(const double f[3], double x, double y)
{
	return f[0] + f[1] * x + f[2] * y;
}

static double height_of(const struct moving *m, double x, double y)
{
	return probe_clamp(along(m->plane, x, y), m->low, m->high);
}

/* Gives the shares of the motion, back from its end, at which the triangle is above a place. Returns false if there are none. */
static bool shares_of(const struct moving *m, double x, double y, double shares[2])
{
	shares[0] = 0;
	shares[1] = 1;
	for (int k = 0; k < 3; k++) {
		const double *edge = m->edges[k], inside = along(edge, x, y) + BESIDE, grows = edge[1] * m->way[0] + edge[2] * m->way[1];
		if (grows > 0)
			shares[0] = probe_most(shares[0], -inside / grows);
		else if (grows < 0)
			shares[1] = probe_least(shares[1], -inside / grows);
		else if (inside < 0)
			return false;
	}
	return shares[0] <= shares[1];
}

static void draw_at(const struct raster *raster, const struct moving *m, size_t column, size_t row)
{
	const double x = raster->corner[0] + (double)column * raster->spacing, y = raster->corner[1] + (double)row * raster->spacing;
	const size_t at = raster->first + row * raster->low.width + column;
	double shares[2];
	if (!shares_of(m, x, y, shares))
		return;
	for (int k = 0; k < 2; k++) {
		const double z = height_of(m, x + shares[k] * m->way[0], y + shares[k] * m->way[1]);
		raster->low.lowest[at] = probe_least(raster->low.lowest[at], z - shares[k] * m->way[2]);
	}
	if (m->resting && shares[0] <= 0)
		raster->low.rests[at] = probe_least(raster->low.rests[at], height_of(m, x, y));
}

static size_t post_from(const struct raster *raster, double place, int axis, size_t most)
{
	return (size_t)probe_clamp(ceil((place - raster->corner[axis]) / raster->spacing), 0, (double)most);
}

static void draw(const struct raster *raster, const double at[3][3], const double way[3], bool resting)
{
	struct moving m;
	if (!moving_of(at, way, resting, &m))
		return;
	size_t from[2], to[2];
	for (int k = 0; k < 2; k++) {
		const double low = probe_least(at[0][k], probe_least(at[1][k], at[2][k])), high = probe_most(at[0][k], probe_most(at[1][k], at[2][k]));
		const size_t most = k == 0 ? raster->columns : raster->rows;
		from[k] = post_from(raster, low - probe_most(way[k], 0) - BESIDE, k, most);
		to[k] = post_from(raster, high - probe_least(way[k], 0) + BESIDE, k, most);
	}
	for (size_t row = from[1]; row < to[1]; row++)
		for (size_t column = from[0]; column < to[0]; column++)
			draw_at(raster, &m, column, row);
}

static void draw_mesh(const struct raster *raster, const struct soil_mesh *mesh, const struct soil_pose *pose, const double way[3])
{
	double axes[3][3];
	soil_axes(pose->yaw, pose->pitch, pose->roll, 0, axes);
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		double at[3][3];
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++) {
				const float *vertex = mesh->vertices[mesh->triangles[t][i]];
				at[i][k] = vertex[0] * axes[0][k] + vertex[1] * axes[1][k] + vertex[2] * axes[2][k];
			}
		draw(raster, (const double(*)[3])at, way, true);
	}
}

static void draw_face(void *user, const struct bar_face *face)
{
	const double way[3] = {face->to[0] - face->from[0], face->to[1] - face->from[1], face->to[2] - face->from[2]};
	double at[3][3];
	for (int i = 0; i < 2; i++) {
		for (int k = 0; k < 3; k++) {
			at[0][k] = face->at[0][k];
			at[1][k] = face->at[1 + i][k];
			at[2][k] = face->at[2 + i][k];
		}
		draw(user, (const double(*)[3])at, way, face->resting);
	}
}

static void clear(const struct raster *raster)
{
	for (size_t row = 0; row < raster->rows; row++)
		for (size_t column = 0; column < raster->columns; column++) {
			const size_t at = raster->first + row * raster->low.width + column;
			raster->low.rests[at] = raster->low.lowest[at] = INFINITY;
		}
}

void deform_low_of(const struct deform_patch *patch, const struct deform_probe *probe, const struct post_rect *below, struct probe_form *form)
{
	const struct soil_shape *shape = probe->shape;
	const double *to = form->axis;
	const double way[3] = {to[0] * form->way[0] - to[1] * form->way[1], to[1] * form->way[0] + to[0] * form->way[1], form->way[2]};
	if (shape->kind != SOIL_MESH && shape->grousers == 0)
		return;
	/* A row and a column more on each side, since slopes are between posts. */
	struct raster raster = {
		.low = {patch->lows, patch->lows + patch->count, patch->width}, .spacing = form->spacing,
		.corner = {-(double)soil_body_from_post(probe->to.x, below->x0 - 1, form->spacing) - probe->beyond[0],
			   -(double)soil_body_from_post(probe->to.y, below->y0 - 1, form->spacing) - probe->beyond[1]},
		.first = (size_t)(below->y0 - 1 - patch->rect.y0) * patch->width + (size_t)(below->x0 - 1 - patch->rect.x0),
		.columns = (size_t)(below->x1 - below->x0 + 2), .rows = (size_t)(below->y1 - below->y0 + 2),
	};
	clear(&raster);
	form->low = raster.low;
	if (shape->kind == SOIL_MESH) {
		draw_mesh(&raster, shape->mesh, &probe->to, way);
		return;
	}
	const bool moves = form->way[0] != 0 || form->way[1] != 0 || form->way[2] != 0;
	const struct bars_motion motion = {.x = -way[0], .y = -way[1], .dx = way[0], .dy = way[1], .z = -way[2], .dz = way[2], .turned = moves ? probe->turned : 0};
	soil_bars(shape, &probe->to, &motion, draw_face, &raster);
}

bool deform_low_is_aloft(const struct probe_law *law, const struct post_rect *below)
{
	const struct deform_patch *patch = law->patch;
	double highest = -INFINITY, lowest = INFINITY;
	for (int64_t y = below->y0; y < below->y1; y++)
		for (int64_t x = below->x0; x < below->x1; x++) {
			const size_t at = (size_t)(y - patch->rect.y0) * patch->width + (size_t)(x - patch->rect.x0);
			highest = patch->posts[at].hole ? highest : probe_most(highest, patch->posts[at].height);
			lowest = probe_least(lowest, law->form.low.rests[at]);
		}
	return lowest + law->above_zero >= highest;
}
