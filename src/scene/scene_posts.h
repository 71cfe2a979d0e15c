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
	{0.5, 198, 55},
	{0.75, 45, 23},
	{1, 27, 23},
	{1.5, 12, 12},
	{2, 12, 6},
	{3, 6, 6},
	{4, 6, 6},
	{6, 1, 4},
	{8, 1, 4},
	{12, 1, 3},
	{16, 1, 1},
};

#endif
