/* Paths from GPX and GeoJSON files; see scene_path.h. */
#include "scene/scene_path.h"

#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "dem/dem.h"

bool scene_path_is_line(const char *file)
{
	const char *ending = strrchr(file, '.');
	return ending != NULL && (strcasecmp(ending, ".gpx") == 0 || strcasecmp(ending, ".geojson") == 0 || strcasecmp(ending, ".json") == 0);
}

bool scene_path_is_other_line(const char *file)
{
	static const char *const endings[] = {".gpkg", ".shp", ".kml", ".kmz", ".fgb", ".gml", ".tcx", ".fit"};
	const char *ending = strrchr(file, '.');
	for (size_t i = 0; ending != NULL && i < sizeof endings / sizeof endings[0]; i++)
		if (strcasecmp(ending, endings[i]) == 0)
			return true;
	return false;
}

/* Receivers tell whole seconds: of points of one second the first is taken. */
static enum status take_times(const struct dem_line *line, const char *told, struct scene_path *path)
{
	size_t kept = 0;
	if (line->times == NULL)
		return fail_with(STATUS_INPUT, "%s: its points have no times; give a speed in m/s beside it", told);
	for (size_t i = 0; i < line->count; i++) {
		const double t = line->times[i] - line->times[0];
		if (kept > 0 && t < path->points[kept - 1].t)
			return fail_with(STATUS_INPUT, "%s: point %zu is %g s before the one before it; give a speed in m/s beside it, or a track in the "
						       "order of time", told, i + 1, path->points[kept - 1].t - t);
		if (kept > 0 && t == path->points[kept - 1].t)
			continue;
		path->points[kept] = path->points[i];
		path->points[kept++].t = t;
	}
	path->count = kept;
	path->timed = true;
	return STATUS_OK;
}

/* A scene is a stranger's: it may name a pipe that nobody writes to, or a device. */
static enum status read_line(const char *file, const char *told, size_t number, struct dem_line *line)
{
	struct stat stats;
	*line = (struct dem_line){.points = NULL};
	if (stat(file, &stats) != 0 || !S_ISREG(stats.st_mode))
		return fail_with(STATUS_INPUT, "%s: there is no such file; name a GPX or GeoJSON file", told);
	if (stats.st_size > SCENE_POSES_BYTES)
		return fail_with(STATUS_INPUT, "%s: it is too large; allowed: %u bytes", told, SCENE_POSES_BYTES);
	return dem_line_read(file, told, number, line);
}

/* Points from `first` to before `end`. */
static enum status take_line(const struct dem_line *line, size_t first, size_t end, struct scene_path *path)
{
	TRY(mem_zeroed(&path->points, end - first, sizeof *path->points, "reading a path"));
	for (size_t i = first; i < end; i++)
		path->points[i - first] = (struct scene_waypoint){.x = line->points[i][0], .y = line->points[i][1]};
	path->count = end - first;
	path->degrees = true;
	return STATUS_OK;
}

enum status scene_path_read_line(const char *file, const char *told, size_t number, bool has_speed, struct scene_path *path)
{
	struct dem_line line;
	enum status status;
	TRY_OR(done, read_line(file, told, number, &line));
	TRY_OR(done, take_line(&line, 0, line.count, path));
	if (!has_speed)
		TRY_OR(done, take_times(&line, told, path));
done:
	dem_line_finish(&line);
	return status;
}

enum status scene_path_read_lines(const char *file, const char *told, struct scene_path **paths, size_t *count)
{
	struct dem_line line;
	enum status status;
	*count = 0;
	TRY_OR(done, read_line(file, told, DEM_EVERY_LINE, &line));
	TRY_OR(done, mem_zeroed(paths, line.lines, sizeof **paths, "reading lines"));
	*count = line.lines;
	for (size_t i = 0; i < line.lines; i++)
		TRY_OR(done, take_line(&line, line.starts[i], i + 1 < line.lines ? line.starts[i + 1] : line.count, &(*paths)[i]));
done:
	dem_line_finish(&line);
	return status;
}
