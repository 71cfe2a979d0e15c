/* What a press has lifted goes to the nearest free posts along the row and the column of the post it leaves. */
#include "deform/reference/reference.h"

static bool inside(const struct reference_ground *ground, int x, int y)
{
	return x >= ground->written.x0 && x < ground->written.x1 && y >= ground->written.y0 && y < ground->written.y1;
}

/* Steps from a post to the nearest free one in a direction; 0: there is none. */
static int steps_to_free(const struct reference_ground *ground, int x, int y, int dx, int dy)
{
	for (int steps = 1; inside(ground, x + steps * dx, y + steps * dy); steps++) {
		int at = (y + steps * dy) * ground->width + x + steps * dx;
		if (ground->contact[at] == 0 && !ground->hole[at])
			return steps;
	}
	return 0;
}

void reference_spread(struct reference_ground *ground)
{
	static const int ways[4][2] = {{0, -1}, {-1, 0}, {1, 0}, {0, 1}};
	double area = ground->spacing * ground->spacing;
	for (int i = 0; i < ground->width * ground->height; i++) {
		int x = i % ground->width, y = i / ground->width, steps[4], nearest = 0, count = 0;
		if (ground->carried[i] == 0)
			continue;
		for (int k = 0; k < 4; k++) {
			steps[k] = steps_to_free(ground, x, y, ways[k][0], ways[k][1]);
			if (steps[k] > 0 && (nearest == 0 || steps[k] < nearest))
				nearest = steps[k];
		}
		for (int k = 0; k < 4; k++)
			count += nearest > 0 && steps[k] == nearest;
		if (count == 0) {
			ground->compacted += ground->carried[i] * area;
			ground->confined += ground->carried[i] * area;
		}
		for (int k = 0; k < 4 && count > 0; k++)
			if (steps[k] == nearest) {
				int at = (y + nearest * ways[k][1]) * ground->width + x + nearest * ways[k][0];
				ground->offset[at] += ground->carried[i] / count;
				ground->heaped[at] += ground->carried[i] / count;
			}
		ground->carried[i] = 0;
	}
}
