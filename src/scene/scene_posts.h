/*
 * How far forces are off, in percent, where so many posts lie below an object: the table "Few posts below a body" of
 * bench/CONVERGE.md. Its bench writes this file, too: python3 bench/converge.py bench-out/converge.jsonl --posts > src/scene/scene_posts.h
 */
#ifndef FURROW_SCENE_POSTS_H
#define FURROW_SCENE_POSTS_H

#define SCENE_POSTS_ROWS 11
/* `posts` or more: no error was larger, of wheels and of other objects. */
static const struct {
	double posts;
	int wheel, other;
} scene_posts[SCENE_POSTS_ROWS] = {
	{0.5, 64, 53},
	{0.75, 27, 22},
	{1, 27, 17},
	{1.5, 5, 13},
	{2, 3, 7},
	{3, 1, 7},
	{4, 1, 2},
	{6, 1, 2},
	{8, 1, 1},
	{12, 1, 1},
	{16, 1, 1},
};

#endif
