/*
 * Buckets that carry: dug full and lifted, dumped into each other, and where it is awkward. After each case offsets + carried + compacted = 0 to the unit, and forces
 * are no more than soil has.
 */
#include <math.h>

#include "../api/rut.h"
#include "../long.h"
#include "../support/near.h"
#include "../support/program.h"

#define DEGREES (M_PI / 180)
#define GROUND 100.0
#define SLOPE 0.5        /* of soil at repose */
#define WEIGHT 16000.0   /* N/m3 */
#define CORNERS 5
#define PLATE 0.012
#define FORCE_MOST 5e5   /* N: pressed straight down by its depth a plate as large as the bucket bears more, by Bekker's law. It grows as the cube of its size */

/* Inside of a loader's bucket of 0.5 m3, rolled back: from the top of its back to its cutting edge, which is as high. x forwards, z up. Its bottom is the last side. */
static const double profile[CORNERS][2] = {{-0.56, 0}, {-0.50, -0.42}, {-0.30, -0.60}, {-0.06, -0.60}, {0.64, 0}};
#define BOTTOM 40.601 /* degrees: so steep is its bottom then */

static double area_of(void)
{
	double area = 0;
	for (int i = 0; i < CORNERS; i++) {
		const double *p = profile[i], *q = profile[(i + 1) % CORNERS];
		area += 0.5 * (p[0] * q[1] - q[0] * p[1]);
	}
	return fabs(area);
}

static double width_of(double scale)
{
	return 0.5 * scale / area_of();
}

/* Writes bucket.obj: outside, inside and the rim between them. scale: of all lengths. */
static void write_bucket(double scale)
{
	static char text[8192];
	size_t at = 0;
	const double width = width_of(1) * scale, plate = PLATE * scale, middle[2] = {0, -0.25};
	for (int k = 0; k < 4; k++)
		for (int i = 0; i < CORNERS; i++) {
			const double out = k < 2 ? plate : 0, dx = profile[i][0] - middle[0], dz = profile[i][1] - middle[1], far = hypot(dx, dz);
			const bool rim = i == 0 || i + 1 == CORNERS;
			at += (size_t)snprintf(text + at, sizeof text - at, "v %.9g %.9g %.9g\n", scale * profile[i][0] + (rim ? copysign(out, dx) : out * dx / far),
					       (k % 2 == 0 ? 1 : -1) * (width / 2 + out), scale * profile[i][1] + (rim ? 0 : out * dz / far));
		}
	for (int k = 0; k < 2; k++)
		for (int i = 0; i + 1 < CORNERS; i++) {
			const int a = 2 * k * CORNERS + i + 1, b = a + CORNERS;
			at += (size_t)snprintf(text + at, sizeof text - at, "f %d %d %d\nf %d %d %d\n", a, a + 1, b + 1, a, b + 1, b);
		}
	for (int k = 0; k < 4; k++)
		for (int i = 1; i + 1 < CORNERS; i++)
			at += (size_t)snprintf(text + at, sizeof text - at, "f %d %d %d\n", k * CORNERS + 1, k * CORNERS + i + 1, k * CORNERS + i + 2);
	const int corners[4] = {1, CORNERS, 2 * CORNERS, CORNERS + 1};
	for (int i = 0; i < 4; i++) {
		const int a = corners[i], b = corners[(i + 1) % 4];
		at += (size_t)snprintf(text + at, sizeof text - at, "f %d %d %d\nf %d %d %d\n", a, b, b + 2 * CORNERS, a, b + 2 * CORNERS, a + 2 * CORNERS);
	}
	assert_true(at < sizeof text);
	support_write(support_path("bucket.obj"), text);
}

struct dig {
	struct furrow_world *world;
	furrow_body body;
	double x, y, z, pitch; /* m; degrees, nose up */
	double force, work;    /* N: the most so far; J against its way */
	double spacing, scale;
};

#define STORE 0.08       /* m between posts of the terrain */
#define BANK 4.5         /* m: where a bank begins */

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return GROUND;
}

/* A bank at repose, 1.2 m high. */
static double bank(int64_t x, int64_t y)
{
	(void)y;
	return GROUND + fmin(fmax(SLOPE * ((double)x * STORE - BANK), 0), 1.2);
}

/* Opens a world for buckets of this size. */
static struct dig open_dig(double spacing, double scale, support_height ground)
{
	struct dig d = {.spacing = spacing, .scale = scale, .body = -1};
	char scene[300];
	const char *store = support_path("bucket.furrow");
	write_bucket(scale);
	support_store(store, (struct extent){129, 129, STORE, 32}, ground);
	snprintf(scene, sizeof scene, "{time_step: 0.02, spacing: %g, soil: {name: dry_sand, unit_weight: %g, repose: %.9g}, redistribute: {model: scm, interval: 0.04}}", spacing, WEIGHT,
		 atan(SLOPE) / DEGREES);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &d.world));
	return d;
}

static struct furrow_pose pose_of(const struct dig *d)
{
	const double half = -0.5 * d->pitch * DEGREES; /* the nose goes up as it turns back about its left */
	return (struct furrow_pose){{d->x, d->y, d->z}, {cos(half), 0, sin(half), 0}};
}

static void add_bucket(struct dig *d, const char *name, bool carries)
{
	char object[300];
	const struct furrow_pose pose = pose_of(d);
	snprintf(object, sizeof object, "{name: %s, shape: {mesh: {file: %s}}%s}", name, support_path("bucket.obj"), carries ? ", carry: true" : "");
	done(furrow_body_add(d->world, object, &d->body));
	done(furrow_place(d->world, d->body, &pose));
	done(furrow_step(d->world, 0));
}

/* Goes there in even steps of at most half a post. */
static void go(struct dig *d, double x, double z, double pitch)
{
	const double from[3] = {d->x, d->z, d->pitch}, way = hypot(x - d->x, z - d->z) + fabs(pitch - d->pitch) * DEGREES * 0.7;
	const int steps = (int)ceil(way / (0.5 * d->spacing)) + 1;
	for (int i = 1; i <= steps; i++) {
		const double part = (double)i / steps, before = d->x;
		d->x = from[0] + (x - from[0]) * part;
		d->z = from[1] + (z - from[1]) * part;
		d->pitch = from[2] + (pitch - from[2]) * part;
		const struct furrow_state state = {.pose = pose_of(d)};
		done(furrow_set_states(d->world, 1, &d->body, &state));
		done(furrow_step(d->world, 0));
		const struct furrow_contact contact = contact_of(d->world, d->body);
		for (int k = 0; k < 3; k++)
			assert_true(isfinite(contact.force[k]) && fabs(contact.force[k]) < FORCE_MOST * pow(fmax(d->scale, 1), 3));
		d->force = support_most(d->force, fabs(contact.force[0]));
		d->work -= contact.force[0] * (d->x - before);
	}
}

static void rest(struct dig *d, double seconds)
{
	for (double t = 0; t < seconds; t += 0.04)
		done(furrow_step(d->world, 0.04));
}

static double litres(const struct dig *d, long long units)
{
	return 1e3 * ldexp((double)units, -OFFSET_BITS) * d->spacing * d->spacing;
}

static long long carried_units(const struct dig *d)
{
	return llround(ldexp(contact_of(d->world, d->body).carried / (d->spacing * d->spacing), OFFSET_BITS));
}

/* Holds the ledger to its law. Returns the soil aboard all bodies, units. */
static long long ledger(const struct dig *d)
{
	struct furrow_info info;
	char *json;
	done(furrow_checkpoint(d->world)); /* sums are those of the last commit */
	double *offsets = hosted_read(d->world, FURROW_OFFSET, &info);
	long long sum = 0;
	for (int64_t i = 0; i < info.columns * info.rows; i++)
		sum += isnan(offsets[i]) ? 0 : llround(ldexp(offsets[i], OFFSET_BITS));
	free(offsets);
	done(furrow_stats(d->world, &json));
	const long long compacted = support_figure(json, "\"quanta\"", "compacted"), carried = support_figure(json, "\"quanta\"", "carried");
	furrow_free(json);
	assert_int_equal(sum + compacted + carried, 0);
	return carried;
}

/* Returns how much lower its lowest place is than its origin, m. */
static double lowest(const struct dig *d, double pitch)
{
	double least = 0;
	for (int i = 0; i < CORNERS; i++)
		least = support_least(least, profile[i][0] * sin(pitch * DEGREES) + profile[i][1] * cos(pitch * DEGREES));
	return -least * d->scale;
}

/* Drives its edge into the ground with its bottom nearly level, goes on, rolls back and is lifted. */
static void dig(struct dig *d, double depth, double way)
{
	d->pitch = -BOTTOM - 8;
	d->z = GROUND + lowest(d, d->pitch) + 0.05;
	const struct furrow_pose pose = pose_of(d);
	done(furrow_place(d->world, d->body, &pose));
	done(furrow_step(d->world, 0));
	go(d, d->x + 0.4, GROUND + lowest(d, -BOTTOM - 8) - depth, -BOTTOM - 8);
	go(d, d->x + way, GROUND + lowest(d, -BOTTOM) - depth, -BOTTOM);
	for (int i = 1; i <= 10; i++) /* its lowest place comes up as it rolls back */
		go(d, d->x + 0.02, GROUND + lowest(d, -BOTTOM * (1 - 0.1 * i)) - depth * (1 - 0.1 * i), -BOTTOM * (1 - 0.1 * i));
	go(d, d->x, GROUND + 2, 0);
	rest(d, 4);
}

static double heaped(void)
{
	const double length = 1.2, width = width_of(1), a = fmax(length, width), b = fmin(length, width);
	return 1e3 * (0.5 + SLOPE * b * b * (3 * a - b) / 12);
}

/* Digs in the bank. */
static struct dig dug(struct dig of, const char *name, double y)
{
	of.x = BANK - 1.4;
	of.y = y;
	of.z = GROUND + 2;
	of.pitch = 0;
	of.force = of.work = 0;
	add_bucket(&of, name, true);
	dig(&of, 0.1, 1.9);
	return of;
}

static void a_bucket_is_dug_full_and_emptied(void **state)
{
	static const double spacings[] = {0.04, 0.02};
	(void)state;
	for (int s = 0; s < (long_run() ? 2 : 1); s++) {
		const struct dig d = open_dig(spacings[s], 1, bank);
		struct dig first = dug(d, "first", 3), second = dug(d, "second", 7);
		const double before = litres(&first, carried_units(&first));
		print_message("posts of %g m: %.1f l dug, by %.0f N at most and %.1f kJ/m3; struck %.1f l\n", spacings[s], before, first.force, first.work / before, 500.0);
		assert_true(before > 500 && before < 1.03 * heaped());
		/* The second one is emptied over the first one. What has no room slides off. */
		go(&second, second.x, GROUND + 4.5, 0);
		second.y = first.y;
		go(&second, first.x - 0.4, GROUND + 4.5, 0);
		for (int pitch = -20; pitch >= -120; pitch -= 20) {
			go(&second, second.x, second.z, pitch);
			rest(&second, 0.4);
		}
		rest(&second, 8);
		const long long full = carried_units(&first), left = carried_units(&second);
		const struct furrow_contact contact = contact_of(d.world, first.body);
		print_message("filled up: %.1f l; struck and heaped are %.1f l: %+.2f %%. It weighs %.1f N\n", litres(&d, full), heaped(), 100 * (litres(&d, full) / heaped() - 1), -contact.force[2]);
		assert_int_equal(ledger(&d), full + left);
		assert_near(litres(&d, full), heaped(), 0.03 * heaped());
		assert_near(-contact.force[2], WEIGHT * contact.carried, 1e-3 * WEIGHT * contact.carried);
		assert_true((double)left < 0.02 * (double)full);
		done(furrow_body_remove(d.world, second.body));
		go(&first, first.x, first.z, -120);
		rest(&first, 2);
		print_message("turned over: %.3f l stay aboard\n", litres(&d, carried_units(&first)));
		assert_true((double)carried_units(&first) < 0.02 * (double)full);
		assert_int_equal(ledger(&d), carried_units(&first));
		done(furrow_world_close(d.world));
	}
}

/* What one bucket dumps above another one lands in it. */
static void a_bucket_dumps_into_another_one(void **state)
{
	(void)state;
	struct dig d = open_dig(0.04, 1, flat), bed;
	d.x = d.y = 3.2;
	d.z = GROUND + 3;
	add_bucket(&d, "bucket", true);
	dig(&d, 0.2, 1.6);
	const long long full = carried_units(&d);
	write_bucket(2);
	bed = d;
	bed.z = GROUND + 1.3;
	bed.pitch = 0;
	add_bucket(&bed, "bed", true);
	bed.force = 0;
	go(&d, d.x, GROUND + 3, 0);
	for (int pitch = -20; pitch >= -120; pitch -= 20) {
		go(&d, d.x, d.z, pitch);
		rest(&d, 0.4);
		ledger(&d);
	}
	rest(&d, 3);
	const long long left = carried_units(&d), landed = carried_units(&bed);
	print_message("%.2f l: %.2f l stay aboard, %.2f l are in the bed\n", litres(&d, full), litres(&d, left), litres(&d, landed));
	assert_int_equal(ledger(&d), left + landed);
	assert_true((double)left < 0.02 * (double)full);
	assert_int_equal(left + landed, full); /* nothing beside it */
	/* Removed, the bed leaves all of it on the ground. */
	done(furrow_body_remove(d.world, bed.body));
	rest(&d, 1);
	assert_int_equal(ledger(&d), left);
	done(furrow_world_close(d.world));
}

static void a_bucket_through_a_corner_of_tiles_keeps_its_load(void **state)
{
	(void)state;
	struct dig d = open_dig(0.04, 0.5, flat); /* tiles of 64 posts of 4 cm */
	d.x = d.y = 2 * 64 * 0.04 - 0.5;
	d.z = GROUND + 2;
	add_bucket(&d, "bucket", true);
	dig(&d, 0.1, 1.2); /* it digs across the border of two tiles; its middle goes along that of two others */
	const long long full = carried_units(&d);
	assert_true(litres(&d, full) > 20);
	assert_int_equal(ledger(&d), full);
	for (int i = 0; i < 40; i++) {
		d.y -= 0.02;
		go(&d, d.x - 0.02, d.z, 0);
	}
	assert_int_equal(carried_units(&d), full);
	done(furrow_world_close(d.world));
}

static void awkward_ways_keep_the_ledger(void **state)
{
	/* From above to where, m and degrees: upside down, below the ground, both, on its back. */
	static const struct {
		const char *name;
		double scale, z, pitch, way;
	} ways[] = {{"upside down", 1, -0.1, 180, 1.2}, {"below the ground", 0.5, -0.4, -BOTTOM, 0.8}, {"upside down below the ground", 0.5, -0.4, 180, 0.6}, {"on its back", 0.5, 0.2, 90, 0.8},
		    {"larger than a window", 8, 4.4, 0, 0.6}};
	(void)state;
	for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
		struct dig d = open_dig(0.04, ways[i].scale, flat);
		d.x = d.y = 4;
		d.z = GROUND + 6;
		d.pitch = ways[i].pitch;
		add_bucket(&d, "bucket", true);
		go(&d, d.x, GROUND + ways[i].z, ways[i].pitch);
		go(&d, d.x + ways[i].way, d.z, ways[i].pitch);
		go(&d, d.x, GROUND + 6, ways[i].pitch);
		rest(&d, 1);
		const long long aboard = carried_units(&d);
		print_message("%s: %.2f l aboard, %.0f N at most\n", ways[i].name, litres(&d, aboard), d.force);
		assert_int_equal(ledger(&d), aboard);
		done(furrow_body_remove(d.world, d.body));
		rest(&d, 1);
		assert_int_equal(ledger(&d), 0);
		done(furrow_world_close(d.world));
	}
}

/* Digs at x, takes the load to another place, m, and turns the bucket over there. Returns what was dug. */
static long long dig_and_empty(struct dig *d, double x, double to)
{
	d->x = x;
	d->y = 5;
	d->z = GROUND + 2;
	add_bucket(d, "bucket", true);
	dig(d, 0.1, 0.6);
	const long long full = carried_units(d);
	go(d, to, d->z, 0);
	assert_int_equal(carried_units(d), full);
	go(d, d->x, d->z, -120);
	rest(d, 2);
	return full;
}

/* Beyond the world there is no ground: what leaves there lands on the last posts, or stays aboard. */
static void soil_over_the_edge_of_the_world_is_not_lost(void **state)
{
	(void)state;
	struct dig d = open_dig(0.04, 0.5, flat);
	const long long full = dig_and_empty(&d, 8.5, 10.2);
	print_message("at the edge: %.2f of %.2f l aboard\n", litres(&d, carried_units(&d)), litres(&d, full));
	assert_true((double)carried_units(&d) < 0.02 * (double)full);
	assert_int_equal(ledger(&d), carried_units(&d));
	done(furrow_world_close(d.world));
}

/* A hole of 2 m. */
static double holed(int64_t x, int64_t y)
{
	return fabs((double)x * STORE - 5) < 1 && fabs((double)y * STORE - 5) < 1 ? NAN : GROUND;
}

/* What falls over a hole lands on its brim, or stays aboard until there is ground. */
static void soil_over_a_hole_is_not_lost(void **state)
{
	(void)state;
	struct dig d = open_dig(0.04, 0.5, holed);
	const long long full = dig_and_empty(&d, 1.5, 5);
	print_message("over the hole: %.2f of %.2f l aboard\n", litres(&d, carried_units(&d)), litres(&d, full));
	assert_true(full > 0 && carried_units(&d) > 0);
	assert_int_equal(ledger(&d), carried_units(&d));
	go(&d, 7.5, d.z, -120);
	rest(&d, 2);
	/* Its back is now above, and nearly level: some soil lies on it. */
	assert_true(carried_units(&d) < full / 10);
	assert_int_equal(ledger(&d), carried_units(&d));
	done(furrow_body_remove(d.world, d.body));
	rest(&d, 1);
	assert_int_equal(ledger(&d), 0);
	done(furrow_world_close(d.world));
}

/* A lid does not touch the load: contacts feel ground alone. The load stays as it is. */
static void a_lid_closes_upon_the_load(void **state)
{
	furrow_body lid = -1;
	(void)state;
	struct dig d = open_dig(0.04, 0.5, flat);
	d.x = d.y = 4;
	d.z = GROUND + 2;
	add_bucket(&d, "bucket", true);
	dig(&d, 0.1, 0.8);
	const long long full = carried_units(&d);
	done(furrow_body_add(d.world, "{name: lid, shape: {box: {size: [0.8, 1, 0.05]}}, carry: true}", &lid));
	const struct furrow_pose above = hosted_pose(d.x, d.y, d.z + 0.6);
	done(furrow_place(d.world, lid, &above));
	for (int i = 0; i <= 20; i++)
		hosted_move(d.world, lid, d.x, d.y, d.z + 0.6 - 0.03 * i);
	rest(&d, 2);
	const struct furrow_contact contact = contact_of(d.world, lid);
	assert_int_equal(carried_units(&d), full);
	assert_int_equal(ledger(&d), full);
	assert_true(contact.force[2] == 0 && contact.carried == 0);
	done(furrow_world_close(d.world));
}

TEST_PROGRAM(buckets)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_bucket_is_dug_full_and_emptied),
		cmocka_unit_test(a_bucket_dumps_into_another_one),
		cmocka_unit_test(a_bucket_through_a_corner_of_tiles_keeps_its_load),
		cmocka_unit_test(awkward_ways_keep_the_ledger),
		cmocka_unit_test(soil_over_the_edge_of_the_world_is_not_lost),
		cmocka_unit_test(soil_over_a_hole_is_not_lost),
		cmocka_unit_test(a_lid_closes_upon_the_load),
	};
	return cmocka_run_group_tests_name("buckets", tests, support_enter, support_leave);
}
