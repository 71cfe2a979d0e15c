/*
 * How far level forces of a body that slides are off. Of a wheel: in percent of its load, by the posts over its radius. Of a blade: in percent of
 * its force, by the posts over its depth. bench/faces_error.py measures that and writes this file:
 * python3 bench/faces_error.py build/tools/furrow --header src/scene/scene_faces_errors.h
 */
#ifndef FURROW_SCENE_FACES_ERRORS_H
#define FURROW_SCENE_FACES_ERRORS_H

enum { SCENE_FACES_ROWS = 4 };
enum scene_faces_wheel { SCENE_FACES_ROLLS, SCENE_FACES_BARS, SCENE_FACES_LOCKED, SCENE_FACES_TURNED, SCENE_FACES_WHEELS };
static const struct {
	double posts;
	int errors[SCENE_FACES_WHEELS];
} scene_faces_wheels[SCENE_FACES_ROWS] = {
	{4, {10, 7, 2, 5}},
	{8, {3, 4, 2, 3}},
	{16, {1, 2, 1, 2}},
	{32, {1, 1, 1, 1}},
};
static const struct {
	double posts;
	int error;
} scene_faces_blades[SCENE_FACES_ROWS] = {
	{1.6, 2},
	{3.2, 1},
	{6.4, 1},
	{12.8, 1},
};

#endif
