/*
 * What a bucket holds: struck, and with a heap at repose, by closed forms (SAE J296). It is filled to overflowing and what is too steep slides off, over walls
 * thinner than a post. Where it is tilted beyond repose, it empties.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../support/near.h"
#include "../support/program.h"
#include "../support.h"
#include "soil/soil.h"

#define DEGREES (M_PI / 180)
#define PLATE 0.01 /* m: how thick its plates are */
#define SIDES 5    /* of its profile, one of which is open */
#define GROUND 3   /* m: it hangs so high */

/* The inside of a bucket as an excavator holds it level: x forwards and z up of its profile, from the top of its back to its cutting edge. */
static const double profile[SIDES + 1][2] = {{-0.60, 0}, {-0.56, -0.36}, {-0.36, -0.60}, {0.04, -0.62}, {0.36, -0.34}, {0.60, 0}};
static const double box[SIDES + 1][2] = {{-0.5, 0}, {-0.5, -0.2}, {-0.5, -0.5}, {0.1, -0.5}, {0.5, -0.5}, {0.5, 0}};

struct bucket {
	struct soil_shape shape;
	struct soil_mesh mesh;
	float vertices[4 * (SIDES + 1)][3];
	uint32_t triangles[64][3];
	double length, width, struck; /* m, m, m3 */
};

static void triangle(struct bucket *b, int i, int j, int k)
{
	uint32_t *t = b->triangles[b->mesh.triangle_count++];
	t[0] = (uint32_t)i;
	t[1] = (uint32_t)j;
	t[2] = (uint32_t)k;
}

static void square(struct bucket *b, int i, int j, int k, int l)
{
	triangle(b, i, j, k);
	triangle(b, i, k, l);
}

/* Makes a closed mesh: the outside, the inside, and the rim between them. The inside is as the profile, of 0.5 m3. */
static void make(struct bucket *b, const double of[SIDES + 1][2])
{
	double area = 0, middle[2] = {0, -0.3};
	const int n = SIDES + 1;
	memset(b, 0, sizeof *b);
	for (int i = 0; i < n; i++)
		area += 0.5 * (of[i][0] * of[(i + 1) % n][1] - of[(i + 1) % n][0] * of[i][1]);
	b->width = 0.5 / fabs(area);
	b->length = of[SIDES][0] - of[0][0];
	b->struck = fabs(area) * b->width;
	b->mesh.vertices = b->vertices;
	b->mesh.triangles = b->triangles;
	for (int k = 0; k < 4; k++) /* outside left and right, inside left and right */
		for (int i = 0; i < n; i++) {
			float *v = b->vertices[b->mesh.vertex_count++];
			const double out = k < 2 ? PLATE : 0, far = hypot(of[i][0] - middle[0], of[i][1] - middle[1]);
			v[0] = (float)(of[i][0] + (i == 0 ? -out : i == SIDES ? out : out * (of[i][0] - middle[0]) / far));
			v[1] = (float)((k % 2 == 0 ? 1 : -1) * (b->width / 2 + out));
			v[2] = (float)(of[i][1] + (i == 0 || i == SIDES ? 0 : out * (of[i][1] - middle[1]) / far));
		}
	for (int k = 0; k < 2; k++)
		for (int i = 0; i < SIDES; i++)
			square(b, 2 * k * n + i, 2 * k * n + i + 1, (2 * k + 1) * n + i + 1, (2 * k + 1) * n + i);
	for (int k = 0; k < 4; k++)
		for (int i = 1; i < SIDES; i++)
			triangle(b, k * n, k * n + i, k * n + i + 1);
	const int corners[4] = {0, SIDES, n + SIDES, n};
	for (int i = 0; i < 4; i++)
		square(b, corners[i], corners[(i + 1) % 4], 2 * n + corners[(i + 1) % 4], 2 * n + corners[i]);
	for (int k = 0; k < 3; k++) {
		b->mesh.low[k] = b->mesh.high[k] = b->vertices[0][k];
		for (uint32_t i = 0; i < b->mesh.vertex_count; i++) {
			b->mesh.low[k] = fmin(b->mesh.low[k], b->vertices[i][k]);
			b->mesh.high[k] = fmax(b->mesh.high[k], b->vertices[i][k]);
		}
	}
	b->shape = (struct soil_shape){.kind = SOIL_MESH, .mesh = &b->mesh};
}

/* Level ground below it. */
static void ground(struct soil_planes *planes, double spacing)
{
	const int64_t half = (int64_t)ceil(2.5 / spacing);
	const size_t count = (size_t)(2 * half) * (size_t)(2 * half);
	*planes = (struct soil_planes){.rect = {-half, -half, half, half}, .width = (size_t)(2 * half)};
	planes->base = calloc(count, sizeof *planes->base);
	planes->offset = calloc(count, sizeof *planes->offset);
	planes->deposited = calloc(count, sizeof *planes->deposited);
	planes->contact = calloc(count, sizeof *planes->contact);
	assert_true(planes->base != NULL && planes->offset != NULL && planes->deposited != NULL && planes->contact != NULL);
}

static int64_t sum_of(const struct soil_planes *planes)
{
	int64_t sum = 0;
	for (size_t i = 0; i < planes->width * (size_t)(planes->rect.y1 - planes->rect.y0); i++)
		sum += planes->offset[i];
	return sum;
}

static void ground_free(struct soil_planes *planes)
{
	free(planes->base);
	free(planes->offset);
	free(planes->deposited);
	free(planes->contact);
}

static struct soil_sliding rule_of(double repose, double spacing)
{
	struct soil_sliding rule = {.class_count = 1, .iterations = 1, .tolerance = (int32_t)lattice_offset(1e-4)};
	rule.classes[0].critical[0] = (int32_t)lattice_offset(repose * spacing);
	rule.classes[0].critical[1] = soil_sliding_diagonal(rule.classes[0].critical[0]);
	return rule;
}

struct held {
	struct bucket bucket;
	struct soil_carried *carried;
	struct soil_planes planes;
	struct soil_pose pose;
	struct soil_sliding rule;
	double unit; /* m3 */
	int64_t brought;
};

/* What lands is taken away, as ground would slide. */
static void settle(struct held *h)
{
	const size_t posts = h->planes.width * (size_t)(h->planes.rect.y1 - h->planes.rect.y0);
	int most = 0;
	do {
		(void)soil_carried_settle(h->carried, &h->pose, &h->rule, &h->planes, 0, h->planes.rect);
		const int64_t landed = sum_of(&h->planes);
		assert_int_equal(h->carried->total + landed, h->brought);
		h->brought -= landed;
		memset(h->planes.offset, 0, posts * sizeof *h->planes.offset);
		memset(h->planes.deposited, 0, posts * sizeof *h->planes.deposited);
	} while (h->carried->unsettled && ++most < 400);
	assert_true(most < 400);
}

/* Hangs a bucket up, and pours soil over it, `deep` m above its rim at each post. */
static void fill(struct held *h, const double of[SIDES + 1][2], double spacing, double repose, double yaw, double at, double deep)
{
	make(&h->bucket, of);
	ground(&h->planes, spacing);
	h->rule = rule_of(repose, spacing);
	h->unit = ldexp(spacing * spacing, -OFFSET_BITS);
	h->pose = (struct soil_pose){.x = lattice_offset(at), .y = lattice_offset(0.7 * at), .z = lattice_offset(GROUND), .yaw = yaw};
	h->brought = 0;
	assert_int_equal(soil_carried_create(&h->bucket.shape, spacing, &h->carried), STATUS_OK);
	soil_carried_place(h->carried, &h->pose);
	for (int64_t y = h->planes.rect.y0; y < h->planes.rect.y1; y++)
		for (int64_t x = h->planes.rect.x0; x < h->planes.rect.x1; x++) {
			const int32_t top = soil_carried_top_at(h->carried, &h->pose, x, y);
			if (top != CARRIED_OPEN)
				h->brought += soil_carried_add(h->carried, &h->pose, x, y, (int32_t)lattice_offset(deep) - top, 0);
		}
	assert_int_equal(h->carried->total, h->brought);
	settle(h);
}

static void finish(struct held *h)
{
	soil_carried_destroy(h->carried);
	ground_free(&h->planes);
}

/* A heap on a rectangle, each of whose faces rises by `slope` from an edge. */
static double heap_of(double length, double width, double slope)
{
	const double a = fmax(length, width), b = fmin(length, width);
	return slope * b * b * (3 * a - b) / 12;
}

static void a_bucket_holds_its_struck_volume_and_a_heap(void **state)
{
	static const double spacings[] = {0.04, 0.02, 0.05}, yaws[] = {0, 0.4, 2.2}, places[] = {0, 0.013, 0.0271};
	static const double reposes[] = {28, 45, 26.565};
	(void)state;
	for (int shape = 0; shape < 2; shape++)
		for (int s = 0; s < 3; s++)
			for (int k = 0; k < (spacings[s] > 0.03 ? 3 : 1); k++) {
				struct held h;
				const double slope = tan(reposes[k] * DEGREES);
				fill(&h, shape ? box : profile, spacings[s], slope, yaws[k], places[k], 0.5);
				const double holds = (double)h.carried->total * h.unit, heap = heap_of(h.bucket.length, h.bucket.width, slope);
				print_message("%s, posts of %g m, repose %g: %.4f m3; struck %.4f and heap %.4f: %+.2f %%\n", shape ? "box" : "bucket", spacings[s], reposes[k], holds,
					      h.bucket.struck, heap, 100 * (holds / (h.bucket.struck + heap) - 1));
				assert_near(holds, h.bucket.struck + heap, 0.03 * (h.bucket.struck + heap));
				finish(&h);
			}
}

/* In soil that levels out like water it holds what is below its rim. */
static void without_repose_it_is_struck(void **state)
{
	static const double spacings[] = {0.04, 0.02};
	(void)state;
	for (int s = 0; s < 2; s++) {
		struct held h;
		fill(&h, profile, spacings[s], 0.01, 0.3, 0.01, 0.3);
		const double holds = (double)h.carried->total * h.unit, wanted = h.bucket.struck + heap_of(h.bucket.length, h.bucket.width, 0.01);
		print_message("posts of %g m: %.4f m3, struck %.4f: %+.2f %%\n", spacings[s], holds, h.bucket.struck, 100 * (holds / wanted - 1));
		assert_near(holds, wanted, 0.03 * wanted);
		finish(&h);
	}
}

/* Turned over in steps about its axis: what is aboard gets less at each step, and in the end nothing is. */
static void it_empties_as_it_turns_over(void **state)
{
	(void)state;
	for (int way = -1; way <= 1; way += 2) {
		struct held h;
		fill(&h, profile, 0.04, tan(28 * DEGREES), 0.2, 0.01, 0.3);
		const double full = (double)h.carried->total;
		double before = full;
		for (int step = 1; step <= 9; step++) {
			h.pose.pitch = way * step * 10 * DEGREES;
			soil_carried_place(h.carried, &h.pose);
			settle(&h);
			assert_true((double)h.carried->total <= before);
			before = (double)h.carried->total;
			print_message("pitched by %d degrees: %.2f %% aboard\n", way * step * 10, 100 * before / full);
		}
		assert_true(before < 0.001 * full);
		finish(&h);
	}
}

TEST_PROGRAM(aboard)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_bucket_holds_its_struck_volume_and_a_heap),
		cmocka_unit_test(without_repose_it_is_struck),
		cmocka_unit_test(it_empties_as_it_turns_over),
	};
	return cmocka_run_group_tests_name("aboard", tests, NULL, NULL);
}
