/*
 * Shapes as triangles, in three details: for objects that are large, middling and small in the picture. The
 * corners of a circle lie on it, so that the drawn form is within the shape. Each detail is off by less than half a pixel.
 *
 * Invariant: triangles are counter-clockwise seen from outside.
 */
#include <math.h>
#include <string.h>

#include "render/objects.h"

/* --- making --- */

static bool make_room(struct object_mesh *mesh)
{
	mesh->failed = mesh->failed ||
		       mem_grow(&mesh->corners, &mesh->corner_room, mesh->corner_count + 1, sizeof *mesh->corners, "objects") != STATUS_OK ||
		       mem_grow(&mesh->indices, &mesh->index_room, mesh->index_count + 3, sizeof *mesh->indices, "objects") != STATUS_OK;
	return !mesh->failed;
}

uint32_t render_object_look(const double normal[3], enum object_material material)
{
	double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
	uint32_t look = (uint32_t)material << 30;
	for (int k = 0; k < 3 && length > 0; k++)
		look |= ((uint32_t)lrint(normal[k] / length * 511) & 1023) << (10 * k);
	return look;
}

uint32_t render_object_mesh_corner(struct object_mesh *mesh, const double at[3], uint32_t look)
{
	if (!make_room(mesh))
		return 0;
	mesh->corners[mesh->corner_count] = (struct object_corner){{(float)at[0], (float)at[1], (float)at[2]}, look};
	return mesh->corner_count++;
}

void render_object_mesh_triangle(struct object_mesh *mesh, uint32_t a, uint32_t b, uint32_t c)
{
	if (!make_room(mesh))
		return;
	const uint32_t corners[3] = {a, b, c};
	memcpy(mesh->indices + mesh->index_count, corners, sizeof corners);
	mesh->index_count += 3;
}

static void end_detail(struct object_mesh *mesh, int detail)
{
	mesh->first[detail + 1] = mesh->index_count;
}

/* Adds a triangle that is counter-clockwise seen from where `outward` points. Adds none if two of its corners are the same. */
static void face(struct object_mesh *mesh, uint32_t a, uint32_t b, uint32_t c, const double outward[3])
{
	if (mesh->failed)
		return;
	const float *p = mesh->corners[a].at, *q = mesh->corners[b].at, *r = mesh->corners[c].at;
	double u[3], v[3], along = 0, size = 0;
	for (int k = 0; k < 3; k++) {
		u[k] = q[k] - p[k];
		v[k] = r[k] - p[k];
	}
	for (int k = 0; k < 3; k++) {
		double n = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
		along += n * outward[k];
		size += fabs(n);
	}
	if (size > 0)
		render_object_mesh_triangle(mesh, a, along >= 0 ? b : c, along >= 0 ? c : b);
}

/* Adds a quadrilateral. Its four corners are given in order around it. */
static void flat(struct object_mesh *mesh, double at[4][3], const double normal[3], enum object_material material)
{
	uint32_t look = render_object_look(normal, material), corners[4];
	for (int i = 0; i < 4; i++)
		corners[i] = render_object_mesh_corner(mesh, at[i], look);
	face(mesh, corners[0], corners[1], corners[2], normal);
	face(mesh, corners[0], corners[2], corners[3], normal);
}

/* Adds a brick. `middle`: its centre; then its three half axes. */
static void brick(struct object_mesh *mesh, const double middle[3], double half[3][3], enum object_material material)
{
	for (int axis = 0; axis < 3; axis++)
		for (int side = -1; side <= 1; side += 2) {
			const double *a = half[(axis + 1) % 3], *b = half[(axis + 2) % 3];
			double at[4][3], normal[3];
			for (int k = 0; k < 3; k++) {
				normal[k] = side * half[axis][k];
				for (int i = 0; i < 4; i++)
					at[i][k] = middle[k] + normal[k] + (i == 1 || i == 2 ? a[k] : -a[k]) + (i >= 2 ? b[k] : -b[k]);
			}
			flat(mesh, at, normal, material);
		}
}

/* --- shapes that are round about the y axis --- */

/* A ring around an axis: its radius, its position along the axis, and its normal (away from the axis, and along it). */
struct ring {
	double radius, y, out, along;
};

/* What becomes of such a shape: the y axis is turned up, or it is stretched along its axes. */
struct form {
	bool upright;
	double stretch[3];
};
static const struct form as_it_is = {false, {1, 1, 1}};

/* Turns a place, or with `normal` a normal, as the form is. */
static void formed(const struct form *form, bool normal, const double at[3], double out[3])
{
	const double turned[3] = {at[0], form->upright ? -at[2] : at[1], form->upright ? at[1] : at[2]};
	for (int k = 0; k < 3; k++)
		out[k] = normal ? turned[k] / form->stretch[k] : turned[k] * form->stretch[k];
}

/* Adds the surface that connects the rings. A full turn has `steps` steps; the surface goes from step `from` to step `to`. */
static void lathe_formed(struct object_mesh *mesh, const struct form *form, const struct ring *rings, int count, int from, int to, int steps,
			 enum object_material material)
{
	uint32_t base = mesh->corner_count, side = (uint32_t)count;
	for (int k = from; k <= to; k++) {
		double c = cos(2 * M_PI * k / steps), s = sin(2 * M_PI * k / steps);
		for (int i = 0; i < count; i++) {
			const struct ring *r = &rings[i];
			double at[3], normal[3];
			formed(form, false, (const double[3]){r->radius * c, r->y, r->radius * s}, at);
			formed(form, true, (const double[3]){r->out * c, r->along, r->out * s}, normal);
			render_object_mesh_corner(mesh, at, render_object_look(normal, material));
		}
	}
	for (int k = from; k < to; k++)
		for (int i = 0; i + 1 < count; i++) {
			double middle = 2 * M_PI * (k + 0.5) / steps, out = rings[i].out + rings[i + 1].out;
			double outward[3];
			formed(form, true, (const double[3]){out * cos(middle), rings[i].along + rings[i + 1].along, out * sin(middle)}, outward);
			uint32_t a = base + (uint32_t)(k - from) * side + (uint32_t)i;
			face(mesh, a, a + 1, a + 1 + side, outward);
			face(mesh, a, a + 1 + side, a + side, outward);
		}
}

static void lathe(struct object_mesh *mesh, const struct ring *rings, int count, int from, int to, int steps, enum object_material material)
{
	lathe_formed(mesh, &as_it_is, rings, count, from, to, steps, material);
}

/* --- a wheel --- */

#define SHOULDER_STEPS 3
#define SPOKES 5

/* Adds the tread and the shoulders of a tyre, from the wall of one side to the wall of the other. */
static void tyre(struct object_mesh *mesh, double radius, double half, double shoulder, int round_steps, int steps)
{
	struct ring rings[2 * SHOULDER_STEPS + 2];
	int count = 0;
	for (int side = -1; side <= 1; side += 2)
		for (int i = 0; i <= round_steps; i++) {
			double angle = M_PI / 2 * (side < 0 ? i : round_steps - i) / round_steps;
			rings[count++] = (struct ring){radius - shoulder * (1 - sin(angle)), side * (half - shoulder * (1 - cos(angle))),
						       sin(angle), side * cos(angle)};
		}
	lathe(mesh, rings, count, 0, steps, steps, OBJECT_RUBBER);
}

/* Adds one side of a wheel: the wall of the tyre, the rim, and the disc with its spokes. */
static void wheel_side(struct object_mesh *mesh, double radius, double half, double shoulder, int side, int steps)
{
	double rim = 0.64 * radius, y = side * half, floor_y = 0.55 * y, cap = 0.16 * radius;
	const struct ring wall[] = {{radius - shoulder, y, 0.05, side}, {0.8 * radius, y, 0, side}, {rim, 0.94 * y, -0.2, side}};
	const struct ring lip[] = {{rim, 0.94 * y, 0, side}, {0.58 * radius, 0.94 * y, 0, side}};
	const struct ring well[] = {{0.58 * radius, 0.94 * y, -1, 0.2 * side}, {0.55 * radius, floor_y, -1, 0.2 * side}};
	const struct ring disc[] = {{0.55 * radius, floor_y, 0, side}, {0, floor_y, 0, side}};
	const struct ring hub[] = {{cap, floor_y, 1, 0}, {cap, 0.82 * y, 1, 0}};
	const struct ring hub_end[] = {{cap, 0.82 * y, 0, side}, {0, 0.86 * y, 0, side}};
	lathe(mesh, wall, 3, 0, steps, steps, OBJECT_RUBBER);
	lathe(mesh, lip, 2, 0, steps, steps, OBJECT_METAL);
	lathe(mesh, well, 2, 0, steps, steps, OBJECT_METAL);
	lathe(mesh, disc, 2, 0, steps, steps, OBJECT_DARK);
	lathe(mesh, hub, 2, 0, steps / 2, steps / 2, OBJECT_METAL);
	lathe(mesh, hub_end, 2, 0, steps / 2, steps / 2, OBJECT_METAL);
	for (int i = 0; i < SPOKES; i++) {
		double c = cos(2 * M_PI * i / SPOKES), s = sin(2 * M_PI * i / SPOKES), middle = 0.33 * radius;
		double axes[3][3] = {{0.235 * radius * c, 0, 0.235 * radius * s}, {0, 0.1 * half, 0}, {-0.06 * radius * s, 0, 0.06 * radius * c}};
		brick(mesh, (const double[3]){middle * c, 0.65 * y, middle * s}, axes, OBJECT_METAL);
	}
}

/* Bars as deform has them (deform.h): evenly round from straight down, forwards turning them back and up. Their inner
 * faces lie in the tyre. */
static void grousers(struct object_mesh *mesh, const struct soil_shape *shape, double shoulder)
{
	double inner = shape->radius - shoulder, outer = shape->radius + shape->grouser_height;
	for (int i = 0; i < shape->grousers; i++) {
		double s = sin(2 * M_PI * i / shape->grousers), c = cos(2 * M_PI * i / shape->grousers);
		double middle = (inner + outer) / 2, reach = (outer - inner) / 2, along = shape->grouser_thickness / 2;
		double axes[3][3] = {{-s * reach, 0, -c * reach}, {0, shape->width / 2, 0}, {-c * along, 0, s * along}};
		brick(mesh, (const double[3]){-s * middle, 0, -c * middle}, axes, OBJECT_RUBBER);
	}
}

static void wheel(struct object_mesh *mesh, const struct soil_shape *shape)
{
	static const int steps[OBJECT_DETAILS] = {64, 28, 14}, rounds[OBJECT_DETAILS] = {SHOULDER_STEPS, 2, 1};
	double half = shape->width / 2, shoulder = fmin(0.12 * shape->radius, 0.35 * half);
	for (int detail = 0; detail < OBJECT_DETAILS; detail++) {
		tyre(mesh, shape->radius, half, shoulder, rounds[detail], steps[detail]);
		for (int side = -1; side <= 1; side += 2)
			wheel_side(mesh, shape->radius, half, shoulder, side, steps[detail]);
		grousers(mesh, shape, shoulder);
		end_detail(mesh, detail);
	}
}

/* --- balls, cylinders, boxes and meshes --- */

#define GORES 8

enum { RINGS_MOST = 32 };

/* Fills the rings of a ball that was cut through its middle and pulled apart by 2 x `half`; 0: of a ball. Returns their count. */
static int ball_rings(double radius, double half, int steps, struct ring rings[RINGS_MOST])
{
	int count = steps / 2 + 1, extra = half > 0;
	for (int i = 0; i < count + extra; i++) {
		int step = i - (extra && i > count / 2);
		double angle = M_PI * step / (count - 1), s = sin(angle), c = -cos(angle);
		rings[i] = (struct ring){radius * s, radius * c + (i <= count / 2 ? -half : half) * extra, s, c};
	}
	return count + extra;
}

/* Adds a shape that is round. Its poles are on its axis. Every second stripe from pole to pole is dark, so that one can see it roll. */
static void round_shape(struct object_mesh *mesh, const struct soil_shape *shape)
{
	static const int steps[OBJECT_DETAILS] = {56, 32, 16};
	struct form form = {shape->kind == SOIL_CYLINDER || shape->kind == SOIL_CAPSULE, {1, 1, 1}};
	bool stretched = shape->kind == SOIL_ELLIPSOID;
	double half = shape->length / 2, r = shape->radius;
	if (stretched)
		memcpy(form.stretch, shape->size, sizeof form.stretch);
	const struct ring parts[3][2] = {{{0, -half, 0, -1}, {r, -half, 0, -1}}, {{r, -half, 1, 0}, {r, half, 1, 0}}, {{r, half, 0, 1}, {0, half, 0, 1}}};
	for (int detail = 0; detail < OBJECT_DETAILS; detail++) {
		struct ring rings[RINGS_MOST];
		int gore = steps[detail] / GORES, count = ball_rings(stretched ? 1 : r, half, steps[detail], rings);
		for (int i = 0; i < GORES; i++) {
			enum object_material look = i % 2 > 0 ? OBJECT_DARK : OBJECT_PAINT;
			if (shape->kind != SOIL_CYLINDER)
				lathe_formed(mesh, &form, rings, count, i * gore, (i + 1) * gore, steps[detail], look);
			for (int part = 0; part < 3 && shape->kind == SOIL_CYLINDER; part++)
				lathe_formed(mesh, &form, parts[part], 2, i * gore, (i + 1) * gore, steps[detail], look);
		}
		end_detail(mesh, detail);
	}
}

enum status render_object_mesh_make(const struct soil_shape *shape, struct object_mesh *mesh)
{
	*mesh = (struct object_mesh){.closed = shape->kind != SOIL_MESH};
	bool plain = shape->kind == SOIL_MESH || shape->kind == SOIL_BOX;
	if (shape->kind == SOIL_WHEEL)
		wheel(mesh, shape);
	else if (!plain)
		round_shape(mesh, shape);
	else if (shape->kind == SOIL_MESH)
		render_object_mesh_of_file(mesh, shape->mesh);
	else
		brick(mesh, (const double[3]){0, 0, 0},
		      (double[3][3]){{shape->size[0] / 2, 0, 0}, {0, shape->size[1] / 2, 0}, {0, 0, shape->size[2] / 2}}, OBJECT_PAINT);
	/* These look the same in all details. */
	for (int detail = 0; detail < OBJECT_DETAILS && plain; detail++)
		end_detail(mesh, detail);
	if (!mesh->failed)
		return STATUS_OK;
	render_object_mesh_finish(mesh);
	return fail_memory("the picture's objects");
}

void render_object_mesh_finish(struct object_mesh *mesh)
{
	mem_free_all(mesh->corners, mesh->indices);
	*mesh = (struct object_mesh){.corners = NULL};
}
