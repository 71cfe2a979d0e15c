/*
 * No vertex moves more than the morph allows between steps of a slow camera, and what meets at an edge agrees. Skipped
 * without GL.
 *
 * The camera looks straight down, so that every pixel's depth is a height; where a pixel's neighbours lie in one plane with
 * it, it is one triangle's, and heights between pixels are exact. So the ground that is drawn at a place can be compared
 * from one picture to the next, and along an edge from one side to the other.
 */
#include "land.h"
#include "../support/program.h"

enum { WIDTH = 192, HEIGHT = 108, PIXELS = WIDTH * HEIGHT, STEPS = 12 };
#define FOV 0.25
#define STEP (1 / 150.0) /* of the height above the ground */

struct frame {
	double eye[3];
	float depth[PIXELS]; /* RENDER_NEAR / metres below the eye */
};

static struct render_selection selection;
static double focal;

static void look_down(struct render *render, const double eye[3], struct frame *frame)
{
	struct render_camera camera = {.eye = {eye[0], eye[1], eye[2]}, .target = {eye[0], eye[1], eye[2] - 1}, .fov = FOV};
	struct render_axes axes;
	struct render_view view;
	render_axes(render, &camera, &axes);
	focal = axes.focal;
	render_view(render, &camera, &view);
	render_select(&land_world, &view, &land_source, &selection);
	assert_int_equal(selection.wanted_count, 0);
	assert_ok(render_frame(render, &camera, &selection));
	land_depth(render, frame->depth);
	memcpy(frame->eye, eye, sizeof frame->eye);
}

/* Whether what is drawn from this pixel to the next ones to the east and the north, and one beyond on every side, is one
 * plane. */
static bool is_flat(const struct frame *frame, int x, int y)
{
	if (x < 1 || y < 1 || x + 2 >= WIDTH || y + 2 >= HEIGHT)
		return false;
	const float *at = frame->depth + y * WIDTH + x;
	double rise_x = (double)at[1] - at[0], rise_y = (double)at[WIDTH] - at[0], enough = 2e-6 * at[0];
	for (int j = -1; j <= 2; j++)
		for (int i = -1; i <= 2; i++)
			if (fabs(at[0] + i * rise_x + j * rise_y - at[j * WIDTH + i]) > enough)
				return false;
	return at[0] > 0;
}

/* Metres by which the second picture's ground lies lower than the first's where the first's pixel is; NaN: not to be told. */
static double moved(const struct frame *from, const struct frame *to, int x, int y)
{
	if (!is_flat(from, x, y))
		return NAN;
	double down = RENDER_NEAR / from->depth[y * WIDTH + x];
	double east = from->eye[0] + (x + 0.5 - WIDTH / 2.0) / focal * down - to->eye[0];
	double north = from->eye[1] + (y + 0.5 - HEIGHT / 2.0) / focal * down - to->eye[1];
	double expected = down + to->eye[2] - from->eye[2];
	double px = east / expected * focal + WIDTH / 2.0 - 0.5, py = north / expected * focal + HEIGHT / 2.0 - 0.5;
	int i = (int)floor(px), j = (int)floor(py);
	if (!is_flat(to, i, j))
		return NAN;
	const float *at = to->depth + j * WIDTH + i;
	return RENDER_NEAR / (at[0] + (px - i) * ((double)at[1] - at[0]) + (py - j) * ((double)at[WIDTH] - at[0])) - expected;
}

struct motion {
	double most, jump; /* metres of ground, a metre of the camera: in a step; in a hundredth of one, where it jumps */
	int compared;      /* pixels */
};

/* Metres of ground, where it changes most. */
static double most_moved(const struct frame *from, const struct frame *to, struct motion *motion)
{
	double most = 0;
	for (int i = 0; i < PIXELS; i++) {
		double by = moved(from, to, i % WIDTH, i / WIDTH);
		motion->compared += !isnan(by);
		most = isnan(by) ? most : fmax(most, fabs(by));
	}
	return most;
}

/* Whichever half of a step the ground changes more in, again and again: what jumps is left, what moves becomes less. */
static double close_in(struct render *render, const struct frame *from, const struct frame *to, struct motion *motion)
{
	static struct frame ends[2], middle;
	double most = 0;
	ends[0] = *from;
	ends[1] = *to;
	for (int i = 0; i < 7; i++) {
		double eye[3];
		for (int k = 0; k < 3; k++)
			eye[k] = (ends[0].eye[k] + ends[1].eye[k]) / 2;
		look_down(render, eye, &middle);
		double first = most_moved(&ends[0], &middle, motion), second = most_moved(&middle, &ends[1], motion);
		ends[first > second] = middle;
		most = fmax(first, second);
	}
	return most;
}

/* Raises the eye to just before the ground below it is drawn with the next stride. */
static void raise_to_change(struct render *render, double eye[3])
{
	static struct frame frame;
	double reaches[RENDER_STRIDES];
	for (int again = 0; again < 3; again++) {
		look_down(render, eye, &frame);
		for (size_t i = 0; i < selection.draw_count; i++) {
			const struct render_draw *draw = &selection.draws[i];
			double low[2], high[2];
			int k = 1;
			struct render_axes axes = {.focal = focal};
			render_box(&land_world, draw->tile, low, high);
			if (eye[0] < low[0] || eye[0] >= high[0] || eye[1] < low[1] || eye[1] >= high[1])
				continue;
			render_reaches(render, &axes, draw, reaches);
			while (k + 1 < RENDER_STRIDES && reaches[k] <= eye[2] - draw->high)
				k++;
			if (reaches[k] < 1e4)
				eye[2] = draw->high + (1 - 2 * STEP) * reaches[k];
			break;
		}
	}
}

/* Short flights from anywhere, a third of them from the ruts, upward and a little to the side. */
static struct motion fly(uint64_t effects, double pixel_error, int flights)
{
	static struct frame frames[2], worst[2];
	struct motion motion = {.most = 0};
	uint64_t dice = 5;
	struct render *render = land_render(WIDTH, HEIGHT, effects, pixel_error);
	for (int i = 0; i < flights; i++) {
		double eye[3], most = 0;
		eye[0] = i % 3 == 0 ? land_dice(&dice, 240, 272) : land_dice(&dice, 60, LAND_SIDE - 61);
		eye[1] = i % 3 == 0 ? land_way(eye[0]) + land_dice(&dice, -1, 1) : land_dice(&dice, 60, LAND_SIDE - 61);
		double ground = land_surface(LAND_FINEST, eye[0], eye[1]);
		eye[2] = ground + 2 * pow(i % 3 == 0 ? 15 : 150, land_dice(&dice, 0, 1));
		raise_to_change(render, eye);
		const double step_way = STEP * (eye[2] - ground), aside[2] = {land_dice(&dice, -0.3, 0.3), land_dice(&dice, -0.3, 0.3)};
		for (int step = 0; step < STEPS; step++) {
			const struct frame *last = &frames[(step + 1) % 2], *now = &frames[step % 2];
			look_down(render, eye, &frames[step % 2]);
			double by = step > 0 ? most_moved(last, now, &motion) : 0;
			if (by > most) {
				most = by;
				worst[0] = *last;
				worst[1] = *now;
			}
			eye[0] += step_way * aside[0];
			eye[1] += step_way * aside[1];
			eye[2] += step_way;
		}
		motion.most = fmax(motion.most, most / step_way);
		if (most > 0)
			motion.jump = fmax(motion.jump, close_in(render, &worst[0], &worst[1], &motion) / step_way);
	}
	render_destroy(render);
	return motion;
}

/* How far a level's posts are off the next one's triangles, at most; metres a metre of the next one's spacing. */
static double roughness(void)
{
	double most = 0;
	for (uint32_t i = 0; i < land.count; i++) {
		struct tile tile = land.tiles[i].tile;
		double spacing = extent_spacing(&land_world, tile.level);
		for (int k = 0; tile.level < extent_coarsest(&land_world) && k < LAND_AREA; k++) {
			double x = (tile.x * LAND_CELLS + k % LAND_POSTS) * spacing, y = (tile.y * LAND_CELLS + k / LAND_POSTS) * spacing;
			double off = fabs(land.tiles[i].heights[k] - land_surface(tile.level + 1, x, y));
			most = fmax(most, off / (2 * spacing));
		}
	}
	return most;
}

static void nothing_moves_faster_than_the_morph_allows(void **state)
{
	need_land();
	const struct {
		double pixels;
		const char *name;
	} details[] = {{0, "by radii"}, {8, "to 8 pixels"}, {40, "to 40 pixels"}};
	for (int i = 0; i < 3; i++) {
		struct motion with = fly(EFFECT_BIT(EFFECT_GEOMORPH), details[i].pixels, 40), without = fly(0, details[i].pixels, 20);
		print_message("%s: %.3g m a metre of the camera, where it jumps %.2g; without morph %.3g and %.2g; %d places\n",
			      details[i].name, with.most, with.jump, without.most, without.jump, with.compared);
		assert_true(with.compared > 1000000);
		/* Without there is something to take out; with it nothing jumps at all. */
		assert_true(without.jump > 0.5);
		assert_true(with.jump < 0.02);
		assert_true(with.most < without.most / 10 || details[i].pixels == 0);
		/* By radii a vertex has a fifth of 24 of its spacings to go from one stride's ground to the next one's. */
		assert_true(with.most < roughness() / (0.2 * 24) || details[i].pixels > 0);
	}
}

/* How much higher the ground is on one side of x = at than on the other, in pixels' sides; NaN where it is not flat up to
 * there. */
static double gap_at(const struct frame *frame, double at, int y)
{
	const float *row = frame->depth + y * WIDTH;
	double c = WIDTH / 2.0;
	/* Where the line is depends on how deep it lies there. */
	for (int i = 0; i < 6; i++) {
		int x = (int)floor(c);
		if (x < 4 || x + 4 >= WIDTH || row[x] == 0)
			return NAN;
		c = (at - frame->eye[0]) * row[x] / RENDER_NEAR * focal + WIDTH / 2.0;
	}
	int left = (int)floor(c - 0.5), right = left + 1;
	if (left < 4 || right + 4 >= WIDTH)
		return NAN;
	double depths[2], steps[2] = {(double)row[left] - row[left - 1], (double)row[right + 1] - row[right]};
	for (int i = 1; i < 3; i++)
		if (fabs((double)row[left - i] - row[left - i - 1] - steps[0]) > 1e-6 * row[left] ||
		    fabs((double)row[right + i + 1] - row[right + i] - steps[1]) > 1e-6 * row[right])
			return NAN;
	depths[0] = row[left] + (c - 0.5 - left) * steps[0];
	depths[1] = row[right] + (c - 0.5 - right) * steps[1];
	return fabs(RENDER_NEAR / depths[0] - RENDER_NEAR / depths[1]) / (RENDER_NEAR / depths[0] / focal);
}

/* Along edges of tiles, which are edges of blocks, too. No skirts. Of what is narrower than a pixel beside the edge the ground
 * on that side is not told: so much may be between. */
static void both_sides_of_an_edge_agree(void **state)
{
	need_land();
	static struct frame frame;
	uint64_t dice = 9;
	double most = 0;
	int places = 0;
	struct render *render = land_render(WIDTH, HEIGHT, EFFECT_BIT(EFFECT_GEOMORPH), 0);
	for (int i = 0; i < 300; i++) {
		bool ruts = i % 3 == 0;
		double side = ruts ? 4 : LAND_CELLS;
		double at = side * floor(ruts ? land_dice(&dice, 240, 272) / side : land_dice(&dice, 2, 14));
		double north = ruts ? land_way(at) + land_dice(&dice, -1, 1) : land_dice(&dice, 60, LAND_SIDE - 61);
		double above = 2 * pow(ruts ? 15 : 150, land_dice(&dice, 0, 1));
		double eye[3] = {at + land_dice(&dice, -0.2, 0.2), north, land_surface(LAND_FINEST, at, north) + above};
		look_down(render, eye, &frame);
		for (int y = 0; y < HEIGHT; y++) {
			double gap = gap_at(&frame, at, y);
			places += !isnan(gap);
			most = isnan(gap) ? most : fmax(most, gap);
		}
	}
	render_destroy(render);
	print_message("%d places on edges, %.2g pixels apart at most\n", places, most);
	assert_true(places > 10000);
	assert_true(most < 1.5);
}

TEST_PROGRAM(vertices)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nothing_moves_faster_than_the_morph_allows),
		cmocka_unit_test(both_sides_of_an_edge_agree),
	};
	return cmocka_run_group_tests(tests, land_open, land_close);
}
