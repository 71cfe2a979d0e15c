/* Checks what a scene says of paths; see scene_way.h. */
#include "scene/scene_way.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/nearest.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_path.h"

/* One path of the scene's text. */
struct way {
	const struct scene_tree *tree;
	const struct raw_path *raw;
	const char *where;
	struct scene_path *path;
};

static const struct scene_node *node_of(const struct way *way, const char *key)
{
	return scene_tree_find(way->tree, "%s%s%s", way->where, key != NULL ? "." : "", key != NULL ? key : "");
}

/* Refuses the first of the keys that is given. `why`: "WHY; WHAT IS ALLOWED". */
static enum status refuse_keys(const struct way *way, const char *const *keys, const char *why)
{
	const struct raw_path *raw = way->raw;
	const struct {
		const char *key;
		bool given;
	} given[] = {{"speed", raw->speed != NULL}, {"loop", raw->loop != NULL},     {"line", raw->line != NULL},
		     {"smooth", raw->smooth != NULL}, {"rotate", raw->rotate != NULL}, {"file", raw->file != NULL},
		     {"points", raw->points != NULL}};
	for (; *keys != NULL; keys++)
		for (size_t i = 0; i < sizeof given / sizeof given[0]; i++)
			if (given[i].given && strcmp(given[i].key, *keys) == 0)
				return scene_error(way->tree->file, node_of(way, *keys), "%s", why);
	return STATUS_OK;
}

static enum status take_points(const struct way *way)
{
	const struct raw_path *raw = way->raw;
	struct scene_path *path = way->path;
	if (raw->speed == NULL)
		return scene_error(way->tree->file, node_of(way, NULL), "has no speed; allowed: points with a speed in m/s");
	TRY(mem_zeroed(&path->points, raw->points_count, sizeof *path->points, "reading the points of a path"));
	path->count = raw->points_count;
	for (uint32_t i = 0; i < raw->points_count; i++)
		path->points[i] = (struct scene_waypoint){.x = raw->points[i][0], .y = raw->points[i][1]};
	return refuse_keys(way, (const char *const[]){"line", NULL}, "does not go with points; allowed with: a file that ends in .gpx or .geojson");
}

static enum status read_file(const struct way *way, const char *file)
{
	const struct raw_path *raw = way->raw;
	const struct scene_told told = scene_told(way->tree->file, node_of(way, "file"), raw->file);
	if (scene_path_is_other_line(file))
		return fail_with(STATUS_INPUT, "%s: lines are read from .gpx and .geojson; convert it: ogr2ogr -t_srs EPSG:4326 LINE.geojson FILE (Mars: "
				 "IAU_2015:49900, the Moon: IAU_2015:30100)", told.text);
	if (scene_path_is_line(file))
		return scene_path_read_line(file, told.text, raw->line != NULL ? (size_t)*raw->line : 0, raw->speed != NULL, way->path);
	TRY(refuse_keys(way, (const char *const[]){"speed", "loop", "line", NULL},
			"does not go with a file of poses, which has times; allowed with: points, or a file that ends in .gpx or .geojson"));
	return scene_path_read(file, told.text, way->path);
}

static enum status take_file(const struct way *way)
{
	char *file = scene_file_beside(way->tree->folder, way->raw->file);
	TRY_MEM(file, "reading a path");
	const enum status status = read_file(way, file);
	mem_free(file);
	return status;
}

static void take_offset(const struct raw_path *raw, double offset[2])
{
	for (int i = 0; i < 2 && raw->offset != NULL; i++)
		offset[i] = raw->offset[i];
}

enum status scene_way_take(const struct scene_tree *tree, const struct raw_path *raw, const char *where, struct scene_path *path)
{
	const struct way way = {tree, raw, where, path};
	const int named = (raw->points != NULL) + (raw->file != NULL) + (raw->relative_to != NULL);
	if (named == 0)
		return scene_error(tree->file, node_of(&way, NULL), "names neither points nor file; allowed: exactly one of points, file, relative_to");
	if (named > 1)
		return scene_error(tree->file, node_of(&way, NULL), "names both %s and %s; allowed: exactly one of points, file, relative_to",
				   raw->points != NULL ? "points" : "file", raw->points != NULL && raw->file != NULL ? "file" : "relative_to");
	path->delay = raw->delay != NULL ? *raw->delay : 0;
	if (raw->relative_to != NULL) {
		take_offset(raw, path->beside);
		return refuse_keys(&way, (const char *const[]){"speed", "loop", "line", "smooth", "rotate", NULL},
				   "does not go with relative_to: the way is the other object's; allowed: offset, delay");
	}
	TRY(raw->points != NULL ? take_points(&way) : take_file(&way));
	const struct scene_node *node = node_of(&way, raw->points != NULL ? "points" : "file");
	path->line = node->setting == NULL ? node->place.line : 0;
	path->speed = raw->speed != NULL ? *raw->speed : 0;
	path->loop = raw->loop != NULL && *raw->loop;
	path->smooth = raw->smooth != NULL && *raw->smooth;
	if (path->smooth && path->has_attitude)
		return scene_error(tree->file, node_of(&way, "smooth"), "its poses say how it turns; allowed with: points, or a file without yaw");
	take_offset(raw, path->offset);
	path->rotate = raw->rotate != NULL ? *raw->rotate * M_PI / 180 : 0;
	for (size_t i = 0; i < path->count && path->has_attitude && path->rotate != 0; i++)
		path->points[i].yaw += path->rotate;
	return STATUS_OK;
}

/* --- paths that follow others --- */

struct following {
	const struct scene_tree *tree;
	const struct raw_scene *raw;
	struct scene *scene;
	size_t *leaders; /* of each object that follows one: its place in the scene's objects */
};

struct named {
	const char *name;
	size_t index;
};

static int by_name(const void *a, const void *b)
{
	return strcmp(((const struct named *)a)->name, ((const struct named *)b)->name);
}

static const char *leader_of(const struct following *following, size_t index)
{
	const struct raw_path *raw = following->raw->objects[index].path;
	return raw != NULL ? raw->relative_to : NULL;
}

static enum status refuse_leader(const struct following *following, size_t index, const char *name, bool there)
{
	const struct scene *scene = following->scene;
	const struct scene_node *node = scene_tree_find(following->tree, "objects[%zu].path.relative_to", index);
	struct scene_list names = {.length = 0};
	struct nearest nearest = nearest_begin(name);
	if (there)
		return scene_error(following->tree->file, node, "%s has no path, the host moves it; allowed: an object with a path",
				   scene_quote(name).text);
	for (size_t i = 0; i < scene->object_count; i++)
		if (i != index) {
			scene_list_add(&names, scene->objects[i].name);
			nearest_offer(&nearest, scene->objects[i].name);
		}
	if (names.length == 0)
		return scene_error(following->tree->file, node, "%s is no object, and there is no other; add it to objects, or give points or a file",
				   scene_quote(name).text);
	return scene_error(following->tree->file, node, "%s is no object; allowed: %s%s", scene_quote(name).text, names.text,
			   nearest_ask(&nearest).text);
}

/* Finds the leader of each follower. `names` is sorted, and has every object. */
static enum status find_leaders(const struct following *following, const struct named *names)
{
	const struct scene *scene = following->scene;
	for (size_t i = 0; i < scene->object_count; i++) {
		const char *leader = leader_of(following, i);
		const struct named *found = leader != NULL ? bsearch(&(struct named){leader, 0}, names, scene->object_count, sizeof *names, by_name) : NULL;
		if (found != NULL)
			following->leaders[i] = found->index;
		if (leader != NULL && (found == NULL || (leader_of(following, found->index) == NULL && scene->objects[found->index].path.count == 0)))
			return refuse_leader(following, i, leader, found != NULL);
	}
	return STATUS_OK;
}

/* Copies the path at the end of the chain of leaders. Offsets and delays of the chain add up, from this object on. */
static enum status follow(const struct following *following, size_t index)
{
	struct scene *scene = following->scene;
	struct scene_path *path = &scene->objects[index].path;
	double beside[2] = {0}, delay = 0;
	size_t at = index;
	for (size_t links = 0; leader_of(following, at) != NULL; links++) {
		const struct raw_path *link = following->raw->objects[at].path;
		for (int i = 0; i < 2; i++)
			beside[i] += link->offset != NULL ? link->offset[i] : 0;
		delay += link->delay != NULL ? *link->delay : 0;
		at = following->leaders[at];
		if (links == scene->object_count)
			return scene_error(following->tree->file, scene_tree_find(following->tree, "objects[%zu].path.relative_to", index),
					   "leads back to %s itself; allowed: a chain that ends at an object with points or a file",
					   scene->objects[index].name);
	}
	delay += scene->objects[at].path.delay;
	*path = scene->objects[at].path;
	path->points = mem_alloc(path->count, sizeof *path->points);
	if (path->points == NULL) {
		path->count = 0;
		return fail_memory("reading a path");
	}
	memcpy(path->points, scene->objects[at].path.points, path->count * sizeof *path->points);
	memcpy(path->beside, beside, sizeof beside);
	path->delay = delay;
	return STATUS_OK;
}

enum status scene_way_follow(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	struct following following = {tree, raw, scene, mem_calloc(scene->object_count + 1, sizeof *following.leaders)};
	struct named *names = mem_calloc(scene->object_count + 1, sizeof *names);
	enum status status;
	TRY_OR(done, following.leaders != NULL && names != NULL ? STATUS_OK : fail_memory("reading a path"));
	for (size_t i = 0; i < scene->object_count; i++)
		names[i] = (struct named){scene->objects[i].name, i};
	qsort(names, scene->object_count, sizeof *names, by_name);
	TRY_OR(done, find_leaders(&following, names));
	for (size_t i = 0; i < scene->object_count; i++) {
		if (leader_of(&following, i) == NULL)
			continue;
		TRY_OR(done, follow(&following, i));
	}
done:
	mem_free_all(names, following.leaders);
	return status;
}
