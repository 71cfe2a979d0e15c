/* Takes the roads of a scene: their lines and widths. Their soils are checked with the other ones. */
#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_path.h"

void scene_roads_finish(struct scene *scene)
{
	for (size_t i = 0; i < scene->road_count; i++) {
		for (size_t k = 0; k < scene->roads[i].line_count; k++)
			mem_free(scene->roads[i].lines[k].points);
		mem_free(scene->roads[i].lines);
	}
	mem_free(scene->roads);
	scene->roads = NULL;
	scene->road_count = 0;
}

static enum status read_lines(const struct scene_tree *tree, const struct scene_node *node, const char *named, struct scene_road *road)
{
	const struct scene_told told = scene_told(tree->file, node, named);
	if (!scene_path_is_line(named))
		return fail_with(STATUS_INPUT, "%s: lines are read from .gpx and .geojson; convert it: ogr2ogr -t_srs EPSG:4326 LINES.geojson FILE", told.text);
	char *file = scene_file_beside(tree->folder, named);
	TRY_MEM(file, "reading roads");
	const enum status status = scene_path_read_lines(file, told.text, &road->lines, &road->line_count);
	mem_free(file);
	return status;
}

static enum status take_points(const struct raw_road *raw, struct scene_road *road)
{
	TRY(mem_zeroed(&road->lines, 1, sizeof *road->lines, "reading roads"));
	road->line_count = 1;
	TRY(mem_zeroed(&road->lines->points, raw->points_count, sizeof *road->lines->points, "reading roads"));
	road->lines->count = raw->points_count;
	for (uint32_t i = 0; i < raw->points_count; i++)
		road->lines->points[i] = (struct scene_waypoint){.x = raw->points[i][0], .y = raw->points[i][1]};
	return STATUS_OK;
}

static enum status take_road(const struct scene_tree *tree, const struct raw_road *raw, uint32_t index, struct scene_road *road)
{
	const struct scene_node *node = scene_tree_find(tree, "ground.roads[%u]%s", index, raw->lines != NULL ? ".lines" : raw->points != NULL ? ".points" : "");
	if ((raw->lines != NULL) == (raw->points != NULL))
		return scene_error(tree->file, node, "names %s lines %s points; allowed: exactly one of them", raw->lines != NULL ? "both" : "neither", raw->lines != NULL ? "and" : "nor");
	road->width = raw->width;
	TRY(raw->lines != NULL ? read_lines(tree, node, raw->lines, road) : take_points(raw, road));
	for (size_t i = 0; i < road->line_count; i++) {
		road->lines[i].smooth = raw->smooth != NULL && *raw->smooth;
		road->lines[i].line = node->setting == NULL ? node->place.line : 0;
	}
	return STATUS_OK;
}

enum status scene_roads_take(const struct scene_tree *tree, const struct raw_ground *raw, struct scene *scene)
{
	TRY(mem_zeroed(&scene->roads, raw->roads_count, sizeof *scene->roads, "reading roads"));
	scene->road_count = raw->roads_count;
	for (uint32_t i = 0; i < raw->roads_count; i++)
		TRY(take_road(tree, &raw->roads[i], i, &scene->roads[i]));
	return STATUS_OK;
}
