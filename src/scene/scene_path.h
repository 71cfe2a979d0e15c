/* Poses in time from a file of comma-separated values. */
#ifndef FURROW_SCENE_PATH_H
#define FURROW_SCENE_PATH_H

#include "scene/scene.h"

#define SCENE_POSES_BYTES (256u << 20)

/*
 * Rows t,x,y or t,x,y,z or t,x,y,z,yaw,pitch,roll, all alike, after an optional line that names
 * these columns: s, the coordinates' unit, metres, degrees; t grows. Fills points (radians), count,
 * timed, has_z and has_attitude. `told`: the place in the scene that names the file.
 */
enum status scene_path_read(const char *file, const char *told, struct scene_path *path)
	FURROW_CHECKED;

#endif
