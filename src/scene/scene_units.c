/*
 * Warns about numbers of a scene that are allowed but probably in a wrong unit. Examples: radians for degrees, kPa for Pa, kN or
 * kg for N, cm for m. The note names the place, the number, the key's unit, and what to write. Nothing is refused.
 */
#include <math.h>
#include <stdio.h>

#include "scene/scene_check.h"

#define DEGREES (180 / M_PI)
#define LEAST_ANGLE SCENE_LEAST_ANGLE
#define LEAST_COHESION SCENE_LEAST_COHESION
#define LEAST_KC 500.0      /* N/m^(n+1): of the soils in the tables the least has 990, and the largest 102 in kN */
#define LARGE_KC 2e5        /* N/m^(n+1): twice the largest of the tables; such a soil may have a small k_phi */
#define LEAST_LOAD 10.0     /* N */
#define LARGE_WHEEL 0.5     /* metres across: its own weight is more than LEAST_LOAD */
#define LARGEST_RADIUS 20.0 /* m */
#define LEAST_SUN 10.0      /* degrees */
#define LEAST_FOV 3.0       /* degrees: of radians nearly the largest */
#define GRAVITY 9.81        /* m/s2, of a load in kg */

struct units {
	const struct scene_tree *tree;
	const struct raw_scene *raw;
	struct scene *scene;
};

/* Keeps "FILE:LINE:COLUMN: KEY: WHY; WHAT TO DO". `why`: the last two. */
static enum status doubt(const struct units *units, const struct scene_node *node, const char *why)
{
	char key[160], text[800];
	struct scene *scene = units->scene;
	scene_node_path(node, false, key, sizeof key);
	if (node->setting != NULL)
		snprintf(text, sizeof text, "%.200s: --set %.100s: %s: %s", units->tree->file, node->setting, key, why);
	else
		snprintf(text, sizeof text, "%.200s:%d:%d: %s: %s", units->tree->file, node->place.line, node->place.column, key, why);
	TRY(mem_resize(&scene->doubts, scene->doubt_count + 1, sizeof *scene->doubts, "reading the scene"));
	scene->doubts[scene->doubt_count] = mem_strdup(text);
	return scene->doubts[scene->doubt_count++] != NULL ? STATUS_OK : fail_memory("reading the scene");
}

/* What to write if the unit is another one. "": that would be doubted as well, so it is not the unit either. */
struct other_unit {
	char text[96];
};
static struct other_unit if_converted(const char *before, double value, int digits, double least, const char *after)
{
	struct other_unit other = {""};
	if (value >= least)
		snprintf(other.text, sizeof other.text, "%s%.*g%s", before, digits, value, after);
	return other;
}

/* Doubts the angle of the soil, or of an object's surface, at `where`. 0 means no friction in any unit. */
static enum status doubt_angle(const struct units *units, const char *where, const char *key, const double *angle)
{
	char why[200];
	if (angle == NULL || *angle == 0 || *angle >= LEAST_ANGLE)
		return STATUS_OK;
	const struct other_unit radians = if_converted("and probably in radians; the unit is degrees: give ", fmin(*angle * DEGREES, 89), 4, LEAST_ANGLE, "");
	snprintf(why, sizeof why, "%g degrees is less than soils have%s%s", *angle, radians.text[0] != '\0' ? ", " : "; the unit is degrees: give 0 for none",
		 radians.text);
	return doubt(units, scene_tree_find(units->tree, "%s.%s", where, key), why);
}

/* The same of cohesion or adhesion. */
static enum status doubt_cohesion(const struct units *units, const char *where, const char *key, const double *cohesion)
{
	char why[200];
	if (cohesion == NULL || *cohesion == 0 || *cohesion >= LEAST_COHESION)
		return STATUS_OK;
	const struct other_unit kilo = if_converted("", *cohesion * 1e3, 6, LEAST_COHESION, ", or ");
	snprintf(why, sizeof why, "%g Pa is less than soils have%s; the unit is Pa: give %s0 for none", *cohesion,
		 kilo.text[0] != '\0' ? ", and probably in kPa" : "", kilo.text);
	return doubt(units, scene_tree_find(units->tree, "%s.%s", where, key), why);
}

/* Doubts k_phi, and tells k_c with it. k_c alone says little: a fit may give any small number. */
static enum status doubt_moduli(const struct units *units, const char *where, const struct raw_class *class)
{
	const double *kphi = class->bekker_kphi, *kc = class->bekker_kc;
	char why[240], with[64] = "";
	if (kphi == NULL || *kphi == 0 || *kphi >= SCENE_LEAST_KPHI || (kc != NULL && *kc >= LARGE_KC))
		return STATUS_OK;
	if (kc != NULL && *kc != 0 && fabs(*kc) < LEAST_KC)
		snprintf(with, sizeof with, ", and bekker_kc %.9g", *kc * 1e3);
	if (*kphi * 1e3 < SCENE_LEAST_KPHI)
		snprintf(why, sizeof why, "%.9g N/m^(n+2) is less than soils have; the unit is N/m^(n+2): give more, as docs/SOILS.md has of its soils", *kphi);
	else
		snprintf(why, sizeof why, "%.9g N/m^(n+2) is less than soils have, and probably in kN/m^(n+2); the unit is N/m^(n+2): give %.9g%s", *kphi,
			 *kphi * 1e3, with);
	return doubt(units, scene_tree_find(units->tree, "%s.bekker_kphi", where), why);
}

static enum status doubt_shear(const struct units *units, const char *where, const double *shear)
{
	char why[240];
	if (shear == NULL || *shear <= SCENE_MOST_SHEAR)
		return STATUS_OK;
	snprintf(why, sizeof why, "%g m is more than soils have, and probably in cm or mm; the unit is m: if it is in cm give %.6g, if it is in mm "
				  "give %.6g",
		 *shear, *shear / 100, *shear / 1000);
	return doubt(units, scene_tree_find(units->tree, "%s.janosi_shear", where), why);
}

static enum status doubt_class(const struct units *units, const char *where, const struct raw_class *class)
{
	const bool bears = deform_model_reads(units->scene->model, "bekker_kphi");
	if (bears)
		TRY(doubt_moduli(units, where, class));
	TRY(doubt_cohesion(units, where, "cohesion", class->cohesion));
	TRY(doubt_cohesion(units, where, "face_cohesion", class->face_cohesion));
	TRY(doubt_angle(units, where, "friction_angle", class->friction_angle));
	if (bears)
		TRY(doubt_shear(units, where, class->janosi_shear));
	return doubt_angle(units, where, "repose", class->repose);
}

static enum status doubt_interfaces(const struct units *units)
{
	for (uint32_t i = 0; i < units->raw->objects_count; i++) {
		const struct raw_interface *interface = units->raw->objects[i].interface;
		char where[48];
		if (interface == NULL)
			continue;
		snprintf(where, sizeof where, "objects[%u].interface", i);
		TRY(doubt_angle(units, where, "friction_angle", interface->friction_angle));
		TRY(doubt_cohesion(units, where, "adhesion", interface->adhesion));
	}
	return STATUS_OK;
}

/* A soil, and what it lies over. */
static enum status doubt_layers(const struct units *units, const char *where, const struct raw_class *soil)
{
	char below[48];
	TRY(doubt_class(units, where, soil));
	if (soil->over == NULL || (soil->over->name != NULL && strcmp(soil->over->name, SCENE_RIGID) == 0))
		return STATUS_OK;
	snprintf(below, sizeof below, "%s.over", where);
	return doubt_class(units, below, soil->over);
}

/* Soils of models that read these keys. */
static enum status doubt_soils(const struct units *units)
{
	const struct raw_soil *soil = units->raw->soil;
	if (soil == NULL || !deform_model_reads(units->scene->model, "friction_angle"))
		return STATUS_OK;
	if (soil->map == NULL)
		return doubt_layers(units, "soil", &soil->all);
	if (soil->elsewhere != NULL)
		TRY(doubt_layers(units, "soil.default", soil->elsewhere));
	for (uint32_t i = 0; i < soil->classes_count; i++) {
		char where[40];
		snprintf(where, sizeof where, "soil.classes[%u]", i);
		TRY(doubt_layers(units, where, &soil->classes[i]));
	}
	return STATUS_OK;
}

static bool is_light(const struct scene_object *object)
{
	return object->load > 0 && object->load < LEAST_LOAD && object->shape.kind == SOIL_WHEEL &&
	       2 * object->shape.radius >= LARGE_WHEEL;
}

/* Doubts a radius that only a building has. */
static enum status doubt_radii(const struct units *units)
{
	static const char *const names[SOIL_SHAPES] = {[SOIL_WHEEL] = "wheel", [SOIL_SPHERE] = "sphere", [SOIL_CYLINDER] = "cylinder", [SOIL_CAPSULE] = "capsule"};
	const struct scene_object *objects = units->scene->objects;
	for (size_t i = 0; i < units->scene->object_count; i++) {
		const struct soil_shape *shape = &objects[i].shape;
		char where[80], why[120];
		if (names[shape->kind] == NULL || shape->radius <= LARGEST_RADIUS)
			continue;
		snprintf(where, sizeof where, "objects[%zu].shape.%s.radius", i, names[shape->kind]);
		snprintf(why, sizeof why, "%g m is large, and perhaps in mm; the unit is m: if it is in mm give %.6g", shape->radius, shape->radius / 1e3);
		TRY(doubt(units, scene_tree_find(units->tree, "%s", where), why));
	}
	return STATUS_OK;
}

/* Wheels with one load and radius get one note. */
static enum status doubt_loads(const struct units *units)
{
	const struct scene_object *objects = units->scene->objects;
	for (size_t i = 0; i < units->scene->object_count; i++) {
		char why[400], others[48] = "";
		size_t before = 0, alike = 0;
		if (!is_light(&objects[i]))
			continue;
		for (size_t j = 0; j < units->scene->object_count && before == 0; j++) {
			bool same = is_light(&objects[j]) && objects[j].load == objects[i].load &&
				    objects[j].shape.radius == objects[i].shape.radius;
			before += same && j < i;
			alike += same && j > i;
		}
		if (before > 0)
			continue;
		if (alike > 0)
			snprintf(others, sizeof others, ", as %zu other%s,", alike, alike > 1 ? "s have" : " has");
		const struct other_unit kilonewtons = if_converted("if it is in kN give ", objects[i].load * 1e3, 6, LEAST_LOAD, "");
		const struct other_unit kilograms = if_converted(", if it is in kg give ", objects[i].load * GRAVITY, 6, LEAST_LOAD, "");
		snprintf(why, sizeof why, "%g N on a wheel of %g m radius%s is less than the wheel's own weight; the unit is N: %s%s%s",
			 objects[i].load, objects[i].shape.radius, others, kilonewtons.text, kilograms.text,
			 kilonewtons.text[0] != '\0' || kilograms.text[0] != '\0' ? "" : "give more");
		TRY(doubt(units, scene_tree_find(units->tree, "objects[%zu].load", i), why));
	}
	return STATUS_OK;
}

/* Doubts the sun's height. A sun near the horizon leaves level ground black, unless its colour makes up for that. */
static enum status doubt_sun(const struct units *units)
{
	const struct raw_view *view = units->raw->view;
	const double *height = view != NULL && view->sun != NULL ? view->sun->height : NULL;
	char why[320], radians[48] = "";
	double brightest = 1;
	const bool bright = view != NULL && view->exposure != NULL && *view->exposure != SCENE_EXPOSURE_FIXED;
	if (height == NULL || *height >= LEAST_SUN || bright)
		return STATUS_OK;
	if (view->sun->colour != NULL)
		brightest = fmax(fmax(view->sun->colour[0], view->sun->colour[1]), view->sun->colour[2]);
	if (brightest * sin(*height / DEGREES) >= sin(LEAST_SUN / DEGREES))
		return STATUS_OK;
	if (*height * DEGREES >= LEAST_SUN && *height <= M_PI / 2)
		snprintf(radians, sizeof radians, "if it is in radians give %.4g, else ", *height * DEGREES);
	snprintf(why, sizeof why, "%g degrees above the horizon: level ground is drawn almost black; the unit is degrees: %sgive %g or more, "
				  "a brighter view.sun.colour, or view.exposure: sun",
		 *height, radians, LEAST_SUN);
	return doubt(units, scene_tree_find(units->tree, "view.sun.height"), why);
}

static enum status doubt_cameras(const struct units *units)
{
	for (uint32_t i = 0; i < units->raw->cameras_count; i++) {
		const double *fov = units->raw->cameras[i].fov;
		char why[200];
		if (fov == NULL || *fov >= LEAST_FOV)
			continue;
		if (*fov * DEGREES < LEAST_FOV)
			snprintf(why, sizeof why, "%g degrees is narrow: so the picture shows little; the unit is degrees: give %g or more for a usual lens", *fov, LEAST_FOV);
		else
			snprintf(why, sizeof why, "%g degrees is narrow, and probably in radians; the unit is degrees: if it is in radians give %.3g", *fov,
				 fmin(*fov * DEGREES, 170));
		TRY(doubt(units, scene_tree_find(units->tree, "cameras[%u].fov", i), why));
	}
	return STATUS_OK;
}

enum status scene_check_units(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	const struct units units = {tree, raw, scene};
	TRY(doubt_soils(&units));
	TRY(doubt_interfaces(&units));
	TRY(doubt_radii(&units));
	TRY(doubt_loads(&units));
	TRY(doubt_sun(&units));
	return doubt_cameras(&units);
}

void scene_advise_units(const struct scene *scene, scene_advice_fn tell, void *user)
{
	for (size_t i = 0; i < scene->doubt_count; i++)
		tell(user, scene->doubts[i]);
}

void scene_drop_doubts(struct scene *scene)
{
	mem_free_list(scene->doubts, scene->doubt_count);
}
