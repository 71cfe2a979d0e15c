/*
 * scm: each post is a spring of soil on its own. Pressed deeper than ever it yields, along Bekker's curve;
 * pressed again it is elastic, down from where it rebounded to; and what slides over it shears it.
 */
#include <math.h>

#include "deform/reference/reference.h"

#define STEEPEST 19.974984 /* the normal's z is 0.05 */

struct vector {
	double x, y, z;
};

/* What one post has of the object. */
struct post {
	struct vector normal; /* of the base */
	double sinkage;       /* p: at the contact's end, along the normal; -INFINITY: not under it */
	double deepest;       /* P: over the contact */
	double largest;       /* z_max' */
	double plastic;       /* what of that stays */
	double stress;        /* along the normal */
	double damping;       /* besides: what comes of the speed */
	bool touched, held;
};

static double dot(struct vector a, struct vector b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct vector cross(struct vector a, struct vector b)
{
	return (struct vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* What remains of a sinkage when the load is gone. */
static double plastic_of(const struct deform_soil *soil, double stiffness, double largest)
{
	return fmax(0, largest - stiffness * pow(largest, soil->bekker_n) / soil->elastic_stiffness);
}

/* How steep the base is along x or y: between the neighbours that there are. What heaped up on it does not count. */
static double slope(const struct reference_ground *ground, int at, int dx, int dy)
{
	int x = at % ground->width, y = at / ground->width, low = at, high = at;
	if (x >= dx && y >= dy && !ground->hole[at - dy * ground->width - dx])
		low = at - dy * ground->width - dx;
	if (x + dx < ground->width && y + dy < ground->height && !ground->hole[at + dy * ground->width + dx])
		high = at + dy * ground->width + dx;
	double rise = ground->base[high] - ground->base[low];
	return low == at || high == at ? rise / ground->spacing : rise / (2 * ground->spacing);
}

static struct vector normal_at(const struct reference_ground *ground, int at)
{
	double east = slope(ground, at, 1, 0), north = slope(ground, at, 0, 1), steep = hypot(east, north);
	/* A wall has no sinkage along its normal: what is steeper than this is taken as this steep. */
	double less = fmin(1, STEEPEST / fmax(steep, 1)), length = hypot(1, less * steep);
	return (struct vector){-east * less / length, -north * less / length, 1 / length};
}

/* b of Bekker's formula: a wheel's width, a box's short side, else the radius of a disc as large as what
 * the object would touch where it comes to rest: of one post at least. */
static double breadth(const struct reference_ground *ground, const struct deform_shape *shape, const double *rest,
		      double lower)
{
	if (shape->kind == DEFORM_WHEEL)
		return shape->width;
	if (shape->kind == DEFORM_BOX)
		return fmin(shape->size[0], shape->size[1]);
	double area = 0;
	for (int i = 0; i < ground->width * ground->height; i++)
		if (!ground->hole[i] && rest[i] - lower < ground->base[i] + ground->heaped[i])
			area += ground->spacing * ground->spacing;
	return sqrt(fmax(area, ground->spacing * ground->spacing) / M_PI);
}

/* How the object's surface at a place moved over the contact. */
static struct vector way_at(const struct deform_contact *sweep, double turned, struct vector from_centre)
{
	/* A wheel's axis is its own y, level; forwards, its lowest point turns backwards. */
	struct vector axis = {-sin(sweep->to.yaw) * turned, cos(sweep->to.yaw) * turned, 0};
	struct vector way = cross(axis, from_centre);
	way.x += lattice_offset_metres(sweep->to.x - sweep->from.x);
	way.y += lattice_offset_metres(sweep->to.y - sweep->from.y);
	if (sweep->load == 0) /* else the height is not a motion but what is looked for */
		way.z += lattice_offset_metres(sweep->to.z - sweep->from.z);
	return way;
}

static struct vector from_centre(const struct reference_ground *ground, const struct deform_contact *sweep, int at,
				 double rest)
{
	return (struct vector){
		(double)(ground->left + at % ground->width) * ground->spacing - lattice_offset_metres(sweep->to.x),
		(double)(ground->bottom + at / ground->width) * ground->spacing - lattice_offset_metres(sweep->to.y),
		rest - lattice_offset_metres(sweep->to.z),
	};
}

static struct post post_of(const struct reference_ground *ground, const struct deform_soil *soil, double stiffness,
			   const struct deform_contact *sweep, int at, double under, double rest, double lower)
{
	struct post post = {.normal = normal_at(ground, at), .sinkage = -INFINITY, .deepest = -INFINITY};
	double undisturbed_here = ground->base[at] + ground->heaped[at];
	if (rest < INFINITY)
		post.sinkage = post.normal.z * (undisturbed_here - (rest - lower));
	if (fmin(under, rest) < INFINITY)
		post.deepest = post.normal.z * (undisturbed_here - (fmin(under, rest) - lower));
	post.largest = fmax(ground->pressed[at], post.deepest);
	post.plastic = plastic_of(soil, stiffness, post.largest);
	post.touched = post.deepest > post.plastic;
	post.held = post.sinkage > post.plastic;
	if (!post.held)
		return post;
	/* Where it yields, that; below, in proportion: K_e, or what is steeper where all of the sinkage is elastic. */
	post.stress = stiffness * pow(post.largest, soil->bekker_n);
	if (post.sinkage < post.largest)
		post.stress *= (post.sinkage - post.plastic) / (post.largest - post.plastic);
	if (sweep->seconds > 0) {
		/* As a wheel rolls that does not slip: how fast soil is pressed does not depend on how fast it spins. */
		struct vector way = way_at(sweep, 0, (struct vector){0, 0, 0});
		double rolls = sweep->shape->kind == DEFORM_WHEEL ? (way.x * cos(sweep->to.yaw) + way.y * sin(sweep->to.yaw)) / sweep->shape->radius : 0;
		double inwards = -dot(way_at(sweep, rolls, from_centre(ground, sweep, at, rest)), post.normal) / sweep->seconds;
		post.damping = soil->damping * fmax(0, inwards);
	}
	return post;
}

double reference_scm_normal(const struct reference_ground *ground, const struct deform_soil *soil,
			    const struct deform_contact *sweep, const double *under, const double *rest, double lower)
{
	double stiffness = reference_stiffness(soil, breadth(ground, sweep->shape, rest, lower)), sum = 0;
	for (int i = 0; i < ground->width * ground->height; i++)
		if (!ground->hole[i] && rest[i] < INFINITY) {
			struct post post = post_of(ground, soil, stiffness, sweep, i, under[i], rest[i], lower);
			sum += (post.stress + post.damping) * post.normal.z * ground->spacing * ground->spacing;
		}
	return sum;
}

/* The stresses of one post, on the object; and the shear that the contact added. */
static void add_forces(struct reference_ground *ground, const struct deform_soil *soil, const struct deform_contact *sweep,
		       int at, double rest, const struct post *post, struct reference_forces *forces)
{
	struct vector arm = from_centre(ground, sweep, at, rest), way = way_at(sweep, sweep->turned, arm);
	double into = dot(way, post->normal), area = ground->spacing * ground->spacing;
	struct vector along = {way.x - into * post->normal.x, way.y - into * post->normal.y, way.z - into * post->normal.z};
	double moved = sqrt(dot(along, along));
	ground->shear[at] += moved;
	double stress = post->stress + post->damping;
	double shear = moved > 0 ? reference_janosi(soil, stress, ground->shear[at]) / moved : 0;
	struct vector force = {
		(stress * post->normal.x - shear * along.x) * area,
		(stress * post->normal.y - shear * along.y) * area,
		(stress * post->normal.z - shear * along.z) * area,
	};
	struct vector moment = cross(arm, force);
	forces->force[0] += force.x;
	forces->force[1] += force.y;
	forces->force[2] += force.z;
	forces->moment[0] += moment.x;
	forces->moment[1] += moment.y;
	forces->moment[2] += moment.z;
	forces->normal += post->stress * post->normal.z * area;
	forces->area += area;
	forces->sinkage = fmax(forces->sinkage, post->sinkage);
}

void reference_scm(struct reference_ground *ground, const struct deform_soil *soil, double bulldozing,
		   const struct deform_contact *sweep, const double *under, const double *rest, double lower,
		   struct reference_forces *forces)
{
	double stiffness = reference_stiffness(soil, breadth(ground, sweep->shape, rest, lower));
	double n = soil->bekker_n, area = ground->spacing * ground->spacing;
	*forces = (struct reference_forces){0};
	for (int i = 0; i < ground->width * ground->height; i++) {
		ground->contact[i] = 0;
		ground->carried[i] = 0;
		if (ground->hole[i])
			continue;
		struct post post = post_of(ground, soil, stiffness, sweep, i, under[i], rest[i], lower);
		double before = plastic_of(soil, stiffness, ground->pressed[i]), was = ground->offset[i];
		if (!post.touched)
			continue;
		if (post.held)
			ground->offset[i] = rest[i] - lower - ground->base[i];
		else
			ground->offset[i] = ground->heaped[i] - post.plastic / post.normal.z;
		ground->contact[i] |= REFERENCE_SWEPT;
		if (post.held)
			ground->contact[i] |= REFERENCE_HELD;
		ground->carried[i] = bulldozing * (post.plastic - before) / post.normal.z;
		ground->compacted += (was - ground->offset[i] - ground->carried[i]) * area;
		forces->work += stiffness * (pow(post.largest, n + 1) - pow(ground->pressed[i], n + 1)) / (n + 1) * area;
		ground->pressed[i] = post.largest;
		if (post.held)
			add_forces(ground, soil, sweep, i, rest[i], &post, forces);
	}
}
