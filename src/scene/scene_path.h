/* Reads poses over time from a file of comma-separated values. */
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

#endif
