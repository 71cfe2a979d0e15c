/*
 * Tells how far off forces may be where few posts lie below an object, and which spacing makes them better. The errors were
 * measured by bench/converge.py (scene_posts.h). Nothing is told where the scene does not say how an object touches the soil. Such
 * an object has neither load nor sink, or it is a box or a mesh whose attitude changes.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_posts.h"

#define TOLD_ABOVE 2 /* percent: smaller errors are not told */

double scene_bears_over(const struct scene *scene, const struct soil_shape *shape, double load, double sink)
{
	double least = shape->kind == SOIL_WHEEL ? shape->width : 2 * shape->radius;
	for (int i = 0; i < scene->soil_count; i++) {
		double sinkage = load > 0 ? soil_sinkage_guess(shape, &scene->soils[i], load) : sink;
		sinkage = fmin(sinkage, 0.9 * shape->radius);
		least = fmin(least, 2 * sinkage * (shape->radius - sinkage) / sqrt(sinkage * (2 * shape->radius - sinkage)));
	}
	return least;
}

double scene_object_bears_over(const struct scene *scene, const struct scene_object *object)
{
	const struct soil_shape *shape = &object->shape;
	if ((object->load <= 0 && object->sink <= 0) || (scene_is_turned(object) && shape->kind != SOIL_WHEEL && shape->kind != SOIL_SPHERE))
		return 0;
	if (shape->kind == SOIL_CYLINDER) /* it is upright */
		return 2 * shape->radius;
	if (shape->kind == SOIL_ELLIPSOID)
		return 0;
	if (shape->kind == SOIL_BOX)
		return fmin(shape->size[0], shape->size[1]);
	if (shape->kind == SOIL_MESH)
		return fmin(shape->mesh->high[0] - shape->mesh->low[0], shape->mesh->high[1] - shape->mesh->low[1]);
	return scene_bears_over(scene, shape, object->load, object->sink);
}

static int error_of_row(const struct soil_shape *shape, size_t row)
{
	return shape->kind == SOIL_WHEEL ? scene_posts[row].wheel : scene_posts[row].other;
}

/* Returns the error in percent that no body of the bench exceeded that had at least so many posts below it. Between two rows it goes with the
 * logarithm of the posts. */
static int error_of(const struct soil_shape *shape, double posts)
{
	size_t row = 0;
	while (row + 1 < SCENE_POSTS_ROWS && posts >= scene_posts[row + 1].posts)
		row++;
	const int error = error_of_row(shape, row);
	if (row + 1 == SCENE_POSTS_ROWS || posts <= scene_posts[row].posts)
		return error;
	const double part = log(posts / scene_posts[row].posts) / log(scene_posts[row + 1].posts / scene_posts[row].posts);
	return (int)lround(error + part * (error_of_row(shape, row + 1) - error));
}

/* Returns whether no object before it is told the same. `others`: how many objects behind it are. */
static bool is_first_told(const struct scene *scene, const struct scene_object *object, size_t *others)
{
	bool wheel = object->shape.kind == SOIL_WHEEL;
	*others = 0;
	for (const struct scene_object *other = scene->objects; other < scene->objects + scene->object_count; other++) {
		if (scene_object_bears_over(scene, other) != scene_object_bears_over(scene, object) || (other->shape.kind == SOIL_WHEEL) != wheel)
			continue;
		if (other < object)
			return false;
		*others += other > object;
	}
	return true;
}

void scene_advise_posts_below(const char *key, const struct soil_shape *shape, double over, size_t others, double spacing, scene_advice_fn tell,
			      void *user)
{
	char text[400], posts[24], alike[48] = "", off[32] = "more than 100 %";
	double finer = spacing;
	const int error = error_of(shape, over / spacing), best = error_of(shape, INFINITY);
	if (error <= TOLD_ABOVE || best >= error)
		return;
	/* The first halving that halves the error; if none does, the first with the least error that the bench knows. */
	while (2 * error_of(shape, over / finer) > error && error_of(shape, over / finer) > best)
		finer /= 2;
	if (others > 0)
		snprintf(alike, sizeof alike, ", as %zu other%s", others, others > 1 ? "s" : "");
	if (error <= 100)
		snprintf(off, sizeof off, "about %d %%", error);
	snprintf(posts, sizeof posts, "%.2g", over / spacing);
	const char *apart = shape->kind == SOIL_WHEEL ? "" : ", without the heaps that it pushes";
	snprintf(text, sizeof text, "%s: the soil bears it over about %.2g m%s, %s post%s: forces may be off by %s here%s; at %g m by %d %%", key, over,
		 alike, posts, strcmp(posts, "1") == 0 ? "" : "s", off, apart, finer, error_of(shape, over / finer));
	tell(user, text);
}

/*
 * The soil's forces on a wheel differ a little with its place between posts, and a slow vehicle has little momentum. So its speed, and the slip of its
 * wheels, goes up and down from post to post. Measured: standard deviations of the rover of docs/tutorials/rover-on-mars.md (140 kg, six wheels of 0.15 m,
 * 3.71 m/s2), the root mean square of its wheels. In brackets the formula.
 *
 *     dry_sand   0.05 m/s       0.1 m/s        0.2 m/s        lete_sand, 0.05 m/s   upland_loam_51, 0.05 m/s
 *     61 mm      0.195 (0.197)  0.096 (0.098)  0.048 (0.049)  0.083                 0.098
 *     30 mm      0.051 (0.049)  0.031 (0.025)  0.020 (0.012)  0.017                 0.034
 *     15 mm      0.029 (0.012)  0.028 (0.006)  0.019 (0.003)  0.014                 0.023
 *     7.6 mm     0.025          0.026          0.015
 *
 * What is left at fine posts is of the way itself: the ground rises and falls, and the rover steers. Of these soils the formula has the one that scatters most.
 */
double scene_slip_scatter(double radius, double spacing, double speed, double gravity)
{
	const double apart = spacing / radius;
	return 0.08 * apart * apart * sqrt(gravity * radius) / speed;
}

void scene_advise_scatter(const char *key, double radius, size_t others, double spacing, double speed, double gravity, scene_advice_fn tell, void *user)
{
	char text[400], alike[48] = "";
	double finer = spacing;
	const double scatter = scene_slip_scatter(radius, spacing, speed, gravity);
	if (!(scatter > SCENE_SCATTER_TOLD))
		return;
	while (scene_slip_scatter(radius, finer, speed, gravity) > SCENE_SCATTER_TOLD)
		finer /= 2;
	if (others > 0)
		snprintf(alike, sizeof alike, ", as of %zu other%s", others, others > 1 ? "s" : "");
	snprintf(text, sizeof text, "%s: with its place between posts its slip goes up and down at %.2g m/s by up to about %.1g (standard deviation)%s; at %g m by %.1g",
		 key, speed, fmin(scatter, 1), alike, finer, scene_slip_scatter(radius, finer, speed, gravity));
	tell(user, text);
}

void scene_advise_posts(const struct scene *scene, double spacing, scene_advice_fn tell, void *user)
{
	if (!deform_tells_forces(scene->model) || !(spacing > 0))
		return;
	for (const struct scene_object *object = scene->objects; object < scene->objects + scene->object_count; object++) {
		char key[160];
		const double over = scene_object_bears_over(scene, object);
		size_t others;
		if (!(over > 0) || (object->load <= 0 && scene->forces <= 0) || !is_first_told(scene, object, &others))
			continue;
		snprintf(key, sizeof key, "objects.%s.shape", object->name);
		scene_advise_posts_below(key, &object->shape, over, others, spacing, tell, user);
	}
}
