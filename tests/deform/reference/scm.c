/*
 * scm: each post is a spring of soil on its own. Pressed deeper than ever it yields, along Bekker's curve;
 * pressed again it is elastic, down from where it rebounded to; and what slides over it shears it.
 */
#include <math.h>

#include "deform/reference/scm.h"

#define STEEPEST 19.974984 /* the normal's z is 0.05 */

/* What one post has of the object. */
struct post {
	struct vector normal; /* of the base, where the object was above it */
	double sinkage;       /* p: at the contact's end, along the normal; -INFINITY: not under it */
	double deepest;       /* P: over the contact */
	double largest;       /* z_max' */
	double plastic;       /* what of that stays */
	bool touched, held;
};

/* Bekker's curve, but no steeper than elastic unloading. */
static double yield_of(const struct soil_numbers *soil, double stiffness, double sinkage)
{
	return fmin(stiffness * pow(sinkage, soil->bekker_n), soil->elastic_stiffness * sinkage);
}

double reference_stays(const struct soil_numbers *soil, double stiffness, double largest)
{
	return fmax(0, largest - yield_of(soil, stiffness, largest) / soil->elastic_stiffness);
}

/* How steep the ground is along x or y, without what is heaped on it: between the neighbours that there are. */
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

struct vector reference_normal_at(const struct reference_ground *ground, int at)
{
	double east = slope(ground, at, 1, 0), north = slope(ground, at, 0, 1), steep = hypot(east, north);
	/* A wall has no sinkage along its normal: what is steeper than this is taken as this steep. */
	double less = fmin(1, STEEPEST / fmax(steep, 1)), length = hypot(1, less * steep);
	return (struct vector){-east * less / length, -north * less / length, 1 / length};
}

/* b of Bekker's formula: a wheel's width, a box's short side, else the radius of a disc as large as what
 * the object would touch where it comes to rest: of one post at least. */
static double breadth(const struct reference_ground *ground, const struct soil_shape *shape, const double *rest,
		      double lower)
{
	if (shape->kind == SOIL_WHEEL)
		return shape->width;
	if (shape->kind == SOIL_BOX)
		return fmin(shape->size[0], shape->size[1]);
	double area = 0;
	for (int i = 0; i < ground->width * ground->height; i++)
		if (!ground->hole[i] && rest[i] - lower < ground->base[i] + ground->heaped[i])
			area += ground->spacing * ground->spacing;
	return sqrt(fmax(area, ground->spacing * ground->spacing) / M_PI);
}

struct vector reference_way_at(const struct deform_contact *sweep, double turned, struct vector from_centre)
{
	/* A wheel's axis is its own y, level; forwards, its lowest point turns backwards. */
	struct vector axis = {-sin(sweep->to.yaw) * turned, cos(sweep->to.yaw) * turned, 0};
	struct vector way = cross(axis, from_centre);
	way.x += lattice_offset_metres(sweep->to.x - sweep->from.x);
	way.y += lattice_offset_metres(sweep->to.y - sweep->from.y);
	way.z += lattice_offset_metres(sweep->to.z - sweep->from.z);
	return way;
}

struct vector reference_belt_along(const struct soil_pose *pose, struct vector normal)
{
	double axes[3][3];
	soil_axes(pose->yaw, pose->pitch, pose->roll, 0, axes);
	const struct vector forward = {axes[0][0], axes[0][1], axes[0][2]}, up = {axes[2][0], axes[2][1], axes[2][2]};
	/* In the body's own upright plane the normal is turned by a right angle: what leans forwards is run over downwards. */
	return plus(plus((struct vector){0, 0, 0}, -dot(normal, up), forward), dot(normal, forward), up);
}

static struct post post_of(const struct reference_ground *ground, const struct soil_numbers *soil, double stiffness, int at, double under,
			   double rest, double lower)
{
	struct post post = {.sinkage = -INFINITY, .deepest = -INFINITY};
	if (fmin(under, rest) < INFINITY)
		post.normal = reference_normal_at(ground, at);
	double undisturbed_here = ground->base[at] + ground->heaped[at];
	if (rest < INFINITY)
		post.sinkage = post.normal.z * (undisturbed_here - (rest - lower));
	if (fmin(under, rest) < INFINITY)
		post.deepest = post.normal.z * (undisturbed_here - (fmin(under, rest) - lower));
	post.largest = fmax(ground->pressed[at], post.deepest);
	post.plastic = reference_stays(soil, stiffness, post.largest);
	post.touched = post.deepest > post.plastic;
	post.held = post.sinkage > post.plastic;
	return post;
}

/* How far the object's lowest surface slips over the ground: for a wheel, beyond rolling. */
static double slips_by(const struct deform_contact *sweep)
{
	struct vector way = reference_way_at(sweep, 0, (struct vector){0, 0, 0});
	double ahead = cos(sweep->to.yaw), aside = sin(sweep->to.yaw), forward = way.x * ahead + way.y * aside;
	if (sweep->shape->belt) {
		double axes[3][3], along[2];
		soil_axes(sweep->to.yaw, sweep->to.pitch, sweep->to.roll, 0, axes);
		for (int k = 0; k < 2; k++)
			along[k] = way.x * axes[k][0] + way.y * axes[k][1] + way.z * axes[k][2];
		return hypot(along[0] - sweep->turned, along[1]);
	}
	if (sweep->shape->kind == SOIL_WHEEL)
		forward = copysign(reference_along(fabs(forward), forward, way.z), forward) - sweep->turned * sweep->shape->radius;
	return hypot(forward, way.y * ahead - way.x * aside);
}

/* The mean of the mobilised shear at a post during the contact, 0 .. 1, by Simpson's rule. */
static double mobilised(const struct reference_ground *ground, const struct soil_numbers *soil, int at, const struct cell_force *cell)
{
	const double before[2] = {ground->shear[0][at], ground->shear[1][at]};
	const struct vector half = {cell->slid.x / 2, cell->slid.y / 2, cell->slid.z / 2};
	double middle[2], after[2];
	reference_shear(before, cell->normal_then, half, soil->janosi_shear, middle);
	reference_shear(before, cell->normal_then, cell->slid, soil->janosi_shear, after);
	return (hypot(before[0], before[1]) + 4 * hypot(middle[0], middle[1]) + hypot(after[0], after[1])) / 6;
}

/* How much slip digs from below the object: of what it lacks of slip_sinkage x K, a share of |e| / K for each way that it slips while the
 * post is in contact. That began at the surface that is dug. Tells since when, in contacts. */
static double digs(const struct reference_ground *ground, const struct soil_numbers *soil, double stiffness, const struct deform_contact *sweep,
		   int at, const double *under, const double *rest, double lower, double *since)
{
	struct cell_force cell = reference_cell(ground, soil, stiffness, sweep, at, under, rest, lower, NAN);
	*since = cell.since;
	double lacks = ground->slip_sinkage * soil->janosi_shear / reference_normal_at(ground, at).z - ground->dug[at];
	struct post post = post_of(ground, soil, stiffness, at, under[at], rest[at], lower);
	if (lacks <= 0 || !post.held)
		return 0;
	double slips = slips_by(sweep) * cell.rim * fmin(fmax(*since, 0), 1) * mobilised(ground, soil, at, &cell);
	/* It never digs itself free. */
	double room = ground->base[at] + ground->heaped[at] - (rest[at] - lower) - 0x1p-19;
	return fmax(0, fmin(lacks * (1 - exp(-slips / soil->janosi_shear)), room));
}

/* What was pressed stays where it is: so it is less deep below ground that was dug. */
static void lower_ground(const struct reference_ground *ground, int at, double dug)
{
	if (dug == 0)
		return;
	ground->heaped[at] -= dug;
	ground->pressed[at] = fmax(0, ground->pressed[at] - reference_normal_at(ground, at).z * dug);
}

double reference_scm_vertical(const struct reference_ground *ground, const struct soil_numbers *soil,
			    const struct deform_contact *sweep, const double *under, const double *rest, double lower)
{
	double stiffness = reference_stiffness(soil, breadth(ground, sweep->shape, rest, lower)), sum = 0;
	for (int i = 0; i < ground->width * ground->height; i++)
		if (!ground->hole[i]) {
			/* For a moment. */
			double heaped = ground->heaped[i], pressed = ground->pressed[i], since;
			lower_ground(ground, i, digs(ground, soil, stiffness, sweep, i, under, rest, lower, &since));
			sum += reference_cell(ground, soil, stiffness, sweep, i, under, rest, lower, since).force.z;
			ground->heaped[i] = heaped;
			ground->pressed[i] = pressed;
		}
	return sum;
}

/* A vector turned about a level axis by the angle that turns the first of two unit vectors, the vertical or a normal, to the other:
 * Rodrigues's formula. */
static struct vector turned_with(struct vector v, struct vector from, struct vector to)
{
	struct vector axis = cross(from, to);
	double sine = sqrt(dot(axis, axis)), cosine = dot(from, to);
	if (sine < 1e-15)
		return v;
	axis = (struct vector){axis.x / sine, axis.y / sine, axis.z / sine};
	struct vector beside = cross(axis, v);
	double along = dot(axis, v) * (1 - cosine);
	return (struct vector){v.x * cosine + beside.x * sine + axis.x * along, v.y * cosine + beside.y * sine + axis.y * along,
			       v.z * cosine + beside.z * sine + axis.z * along};
}

/* The object's surface moved by `along` over the post. Soil sheared by e, in units of K, gives way: de = dj - e |dj|. So e nears the
 * direction of the way, and what it lacks of that falls by a factor of exp for each K. */
struct vector reference_shear(const double before[2], struct vector normal, struct vector along, double modulus, double after[2])
{
	const struct vector up = {0, 0, 1};
	double way = sqrt(dot(along, along)), lacks = exp(-way / modulus);
	struct vector e = turned_with((struct vector){before[0], before[1], 0}, up, normal);
	if (way > 0)
		e = (struct vector){along.x / way + (e.x - along.x / way) * lacks, along.y / way + (e.y - along.y / way) * lacks,
				    along.z / way + (e.z - along.z / way) * lacks};
	struct vector level = turned_with(e, normal, up);
	after[0] = level.x;
	after[1] = level.y;
	return e;
}

static void add_forces(const struct cell_force *cell, struct reference_forces *forces)
{
	const double force[3] = {cell->force.x, cell->force.y, cell->force.z};
	const double moment[3] = {cell->moment.x, cell->moment.y, cell->moment.z};
	for (int k = 0; k < 3; k++) {
		forces->force[k] += force[k];
		forces->moment[k] += moment[k];
	}
	forces->normal += cell->normal;
	forces->area += cell->area;
}

/* What Bekker's curve takes to be pressed from one sinkage to another, J/m2. */
static double work_of(const struct soil_numbers *soil, double stiffness, double from, double to)
{
	struct soil_numbers same = *soil;
	same.bekker_kc = 0;
	same.bekker_kphi = stiffness;
	return reference_yield_work(&same, 1, to) - reference_yield_work(&same, 1, from);
}

/* Where the object was, but no longer is in contact, the shear ends. What is two posts' spacing below it has to do with another. */
static bool is_near(const struct reference_ground *ground, int at, double lowest)
{
	return lowest - ground->base[at] - ground->offset[at] < 2 * ground->spacing;
}

void reference_scm(struct reference_ground *ground, const struct soil_numbers *soil, double bulldozing,
		   const struct deform_contact *sweep, const double *under, const double *rest, double lower,
		   struct reference_forces *forces)
{
	double stiffness = reference_stiffness(soil, breadth(ground, sweep->shape, rest, lower));
	double area = ground->spacing * ground->spacing;
	*forces = (struct reference_forces){0};
	for (int i = 0; i < ground->width * ground->height; i++) {
		ground->contact[i] = 0;
		ground->carried[i] = 0;
		if (ground->hole[i])
			continue;
		bool touched = post_of(ground, soil, stiffness, i, under[i], rest[i], lower).touched;
		double since, dug = digs(ground, soil, stiffness, sweep, i, under, rest, lower, &since);
		lower_ground(ground, i, dug);
		struct post post = post_of(ground, soil, stiffness, i, under[i], rest[i], lower);
		double before = reference_stays(soil, stiffness, ground->pressed[i]), was = ground->offset[i];
		/* A cell may bear whose middle does not. */
		struct cell_force cell = reference_cell(ground, soil, stiffness, sweep, i, under, rest, lower, since);
		add_forces(&cell, forces);
		double sheared[2] = {0, 0};
		if (post.held)
			reference_shear((const double[2]){ground->shear[0][i], ground->shear[1][i]}, cell.normal_then, cell.slid, soil->janosi_shear, sheared);
		if (post.held || is_near(ground, i, fmin(under[i], rest[i]) - lower))
			for (int part = 0; part < 2; part++)
				ground->shear[part][i] = sheared[part];
		if (!touched)
			continue;
		ground->dug[i] += dug;
		if (post.held)
			ground->offset[i] = rest[i] - lower - ground->base[i];
		else
			ground->offset[i] = ground->heaped[i] - post.plastic / post.normal.z;
		ground->contact[i] |= REFERENCE_SWEPT;
		if (post.held)
			ground->contact[i] |= REFERENCE_HELD;
		ground->carried[i] = bulldozing * (post.plastic - before) / post.normal.z + dug;
		ground->compacted += (was - ground->offset[i] - ground->carried[i]) * area;
		forces->work += work_of(soil, stiffness, ground->pressed[i], post.largest) * area;
		ground->pressed[i] = post.largest;
		if (post.held)
			forces->sinkage = fmax(forces->sinkage, post.sinkage);
	}
}
