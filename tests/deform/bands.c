/*
 * Bands of laid soil: how large, how round and where they are depends neither on the spacing of posts nor on the axes nor on windows.
 * Directions are 0, 22.5 and 45 degrees, spacings are halved twice.
 */
#include "ground.h"

static const double headings[] = {0, M_PI / 8, M_PI / 4};

static struct ground_params soil_of(enum deform_model model, double spacing, uint32_t tiles, const struct deform_soil *soil)
{
	return (struct ground_params){.cells = 64, .tiles = tiles, .spacing = spacing, .model = model, .soils = soil, .soil_count = 1,
				      .iterations = 1, .bulldozing = model == DEFORM_SCM ? 1 : 0, .stands = true};
}

static struct deform_soil loose(enum deform_model model)
{
	struct deform_soil soil;
	assert_ok(deform_soil_named(model == DEFORM_SUMNER ? "sand" : "dry_sand", &soil));
	soil.cohesion = 0;
	return soil;
}

/* A post of the block from a place on a line, in metres along it and to its left. */
static void place_of(const struct ground *ground, int64_t at, double x, double y, double heading, double place[2])
{
	double east = (double)(at % ground->posts) * ground->params.spacing - x, north = (double)(at / ground->posts) * ground->params.spacing - y;
	place[0] = east * cos(heading) + north * sin(heading);
	place[1] = north * cos(heading) - east * sin(heading);
}

struct way {
	const struct deform_shape *shape;
	double x, y, heading, length, sink, load; /* from its middle, m; N */
	double slip; /* 1: locked */
};

/* A body along a straight way, a post from sample to sample. The mean height of its centre over the second half of the way. */
static double drive(struct ground *ground, const struct way *way)
{
	double d = ground->params.spacing, sum = 0;
	int samples = (int)lround(way->length / d), counted = 0;
	struct deform_contact sweep = {.shape = way->shape, .load = way->load, .seconds = way->load > 0 ? d : 0, .tag = way->load > 0};
	for (int i = 0; i <= samples; i++) {
		double along = i * d - way->length / 2;
		struct deform_pose pose = ground_pose(ground, (way->x + along * cos(way->heading)) / d, (way->y + along * sin(way->heading)) / d,
						      deform_shape_reach(way->shape, 0, 0) - way->sink);
		pose.yaw = way->heading;
		sweep.from = i == 0 ? pose : sweep.to;
		sweep.to = pose;
		sweep.turned = i == 0 ? 0 : (1 - way->slip) * d / way->shape->radius;
		ground_sweep(ground, &sweep);
		if (way->load == 0)
			continue;
		struct deform_forces forces;
		bool taken = false;
		assert_ok(deform_forces_begin(ground->deform));
		assert_ok(deform_forces_take(ground->deform, true, &forces, &taken));
		assert_true(taken);
		if (i > samples / 2 && i < samples - 4) {
			sum += lattice_offset_metres(forces.z);
			counted++;
		}
	}
	ground_read(ground);
	return counted > 0 ? sum / counted : 0;
}

struct berm {
	double left, right, widest, crest, corridor, hollow; /* m2: sections; m; m2 raised in the corridor; m2 lowered */
};

static struct berm berm_of(const struct ground *ground, const struct way *way, double half_width, double from, double to)
{
	struct berm berm = {0};
	double area = ground->params.spacing * ground->params.spacing;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		double place[2], height = lattice_offset_metres(ground->offset[i]);
		place_of(ground, i, way->x, way->y, way->heading, place);
		if (place[0] < from || place[0] >= to || height == 0)
			continue;
		double section = height * area / (to - from);
		if (height < 0)
			berm.hollow -= section;
		else if (fabs(place[1]) <= half_width)
			berm.corridor += section;
		else if (place[1] > 0)
			berm.left += section;
		else
			berm.right += section;
		if (height > 0.0005)
			berm.widest = fmax(berm.widest, fabs(place[1]) - half_width);
		berm.crest = fmax(berm.crest, height);
	}
	return berm;
}

/* All that a rolling wheel displaces lies beside its way: half on each side, in a band as wide as the rule says. */
static void a_rolling_wheel_lays_the_same_berm_at_every_spacing(void **state)
{
	const struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = 0.5, .width = 0.5};
	const struct deform_soil soil = loose(DEFORM_SLIPPAGE);
	double sink = 0.02, half = wheel.width / 2, width = sqrt(4.5 * sink * half / tan(soil.friction_angle));
	(void)state;
	need_gpu();
	for (int k = 0; k < 9; k++) {
		double d = 0.04 / (1 << k / 3);
		struct ground ground;
		const struct ground_params params = soil_of(DEFORM_SLIPPAGE, d, (uint32_t)(1 << k / 3), &soil);
		ground_init(&ground, &params);
		const struct way way = {.shape = &wheel, .x = 1.283, .y = 1.271, .heading = headings[k % 3], .length = 1, .sink = sink};
		drive(&ground, &way);
		struct berm berm = berm_of(&ground, &way, half, -0.25, 0.25);
		double wanted = sink * wheel.width / 2;
		print_message("%g m, %g degrees: %.5g and %.5g m2 of %.5g; %.3g m wide of %.3g, %.4g m high\\n", d, way.heading * 180 / M_PI,
			      berm.left, berm.right, wanted, berm.widest, width, berm.crest);
		assert_true(fabs(berm.left + berm.right - berm.hollow) < 0.02 * berm.hollow);
		assert_true(fabs(berm.left - wanted) < 0.06 * wanted + 0.3 * sink * d && fabs(berm.right - wanted) < 0.06 * wanted + 0.3 * sink * d);
		assert_true(fabs(berm.widest - width) < 0.05 * width + d);
		/* Its section is two thirds of its width times its height. */
		assert_true(fabs(berm.crest - 1.5 * wanted / width) < 0.15 * 1.5 * wanted / width);
		assert_true(berm.corridor == 0);
		ground_finish(&ground);
	}
}
