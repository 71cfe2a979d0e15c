/* Reads paths from files: poses over time from comma-separated values, and lines on the globe. */
#ifndef FURROW_SCENE_PATH_H
#define FURROW_SCENE_PATH_H

#include "scene/scene.h"

#define SCENE_POSES_BYTES (256u << 20)

/*
 * Reads a poses file. All rows have the same columns: t,x,y or t,x,y,z or t,x,y,z,yaw,pitch,roll. The first line may name these
 * columns. Units: s; the unit of `coordinates`; metres; degrees. t must grow from row to row. Fills points (angles in radians),
 * count, timed, has_z and has_attitude. `told`: the place in the scene that names the file.
 */
enum status scene_path_read(const char *file, const char *told, struct scene_path *path)
	FURROW_CHECKED;

bool scene_path_is_line(const char *file); /* by its ending: .gpx, .geojson or .json */
bool scene_path_is_other_line(const char *file); /* by its ending: a format of lines that is not read */
/*
 * Reads line `number` (from 1; 0: its only one) of a GPX or GeoJSON file. Fills points, count, degrees; and timed, with times from the
 * first point on, unless the line has a speed of its own. STATUS_INPUT: there is no such line, or it has no times and needs them.
 */
enum status scene_path_read_line(const char *file, const char *told, size_t number, bool has_speed, struct scene_path *path) FURROW_CHECKED;
/* Reads every line of such a file: points, count, degrees. The caller frees each path's points, and the paths, even on failure. */
enum status scene_path_read_lines(const char *file, const char *told, struct scene_path **paths, size_t *count) FURROW_CHECKED;
/* The pitch of a wheel only turns it about its axle. So waypoints with camber get pitch 0, and the yaw and roll of the same axle. */
void scene_level_pitch(const struct soil_shape *shape, struct scene_path *path);

#endif
