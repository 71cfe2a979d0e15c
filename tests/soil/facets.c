/* The facets of a body are its whole surface: they look outwards, they close, and they have its area and its volume. */
#include "soil_test.h"

#include "../support/program.h"
#include "meshes.h"
#include "soil/faces/facets.h"

/* Sums over facets, in doubles. tensor: of place times vector; a closed body has its volume three times on the diagonal and zeros beside it. */
struct sums {
	double vector[3], area, by_kind[2], volume, tensor[3][3];
};

static double vector_at(const struct soil_facets *f, size_t i, int k)
{
	return (double)(k == 0 ? f->nx : k == 1 ? f->ny : f->nz)[i] * (double)f->area[i];
}

static double place_at(const struct soil_facets *f, size_t i, int k)
{
	return (double)(k == 0 ? f->x : k == 1 ? f->y : f->z)[i];
}

static struct sums sums_of(const struct soil_facets *f)
{
	struct sums s = {0};
	for (size_t i = 0; i < f->count; i++) {
		s.area += (double)f->area[i];
		s.by_kind[f->kind[i]] += (double)f->area[i];
		for (int k = 0; k < 3; k++) {
			s.vector[k] += vector_at(f, i, k);
			s.volume += place_at(f, i, k) * vector_at(f, i, k) / 3;
			for (int j = 0; j < 3; j++)
				s.tensor[k][j] += place_at(f, i, k) * vector_at(f, i, j);
		}
	}
	return s;
}

/* Checks what holds for facets of any shape. */
static void check(const struct soil_facets *f)
{
	assert_true(f->room > 0 && f->room >= f->count && f->room % SOIL_FACETS_LANES == 0 && f->room - f->count < SOIL_FACETS_LANES + (f->count == 0));
	assert_true(f->count <= SOIL_FACETS_MOST);
	for (size_t i = 0; i < f->room; i++) {
		double length = 0, out = 0;
		for (int k = 0; k < 3; k++) {
			const double n = (double)(k == 0 ? f->nx : k == 1 ? f->ny : f->nz)[i], at = place_at(f, i, k);
			length += n * n;
			out += at * at;
			assert_true(at >= f->low[k] - 1e-6 * f->reach && at <= f->high[k] + 1e-6 * f->reach);
		}
		assert_near(length, 1, 1e-6);
		assert_true(sqrt(out) <= f->reach * (1 + 1e-6));
		assert_true(i < f->count ? f->area[i] > 0 : !(f->area[i] > 0) && f->nz[i] > 0.99f && f->kind[i] == FACET_UNDER);
	}
}

static struct sums sums_for(const struct soil_shape *shape, double size)
{
	struct soil_facets f = {0};
	assert_ok(soil_facets_of(shape, size, &f));
	check(&f);
	const struct sums s = sums_of(&f);
	soil_facets_finish(&f);
	return s;
}

static void check_closed(const struct sums *s, double volume, double within)
{
	for (int k = 0; k < 3; k++) {
		assert_near(s->vector[k], 0, 1e-6 * s->area);
		for (int j = 0; j < 3; j++)
			assert_near(s->tensor[k][j], k == j ? volume : 0, (k == j ? within : 1e-5) * volume);
	}
	assert_near(s->volume, volume, within * volume);
}

/* A shape, its volume, its area in all, and that of its sides. */
struct known {
	const char *name;
	struct soil_shape shape;
	double volume, area, sides, scale; /* scale: m, of which an eighth is a small size */
};

#define R 0.25
#define W 0.12
static double oblate_area(double a, double c) /* two half axes a, one c < a */
{
	const double e = sqrt(1 - c * c / (a * a));
	return 2 * M_PI * a * a * (1 + (1 - e * e) / e * atanh(e));
}

static double prolate_area(double a, double c) /* two half axes a, one c > a */
{
	const double e = sqrt(1 - a * a / (c * c));
	return 2 * M_PI * a * a * (1 + c / (a * e) * asin(e));
}

static size_t all_known(struct known *list)
{
	const struct known all[] = {
		{"wheel", {.kind = SOIL_WHEEL, .radius = R, .width = W}, M_PI * R * R * W, 2 * M_PI * R * (R + W), 2 * M_PI * R * R, R},
		{"sphere", {.kind = SOIL_SPHERE, .radius = R}, 4 * M_PI / 3 * R * R * R, 4 * M_PI * R * R, 0, R},
		{"box", {.kind = SOIL_BOX, .size = {0.5, 0.3, 0.2}}, 0.03, 0.62, 0.32, 0.1},
		{"cylinder", {.kind = SOIL_CYLINDER, .radius = R, .length = W}, M_PI * R * R * W, 2 * M_PI * R * (R + W), 2 * M_PI * R * R, R},
		{"capsule", {.kind = SOIL_CAPSULE, .radius = R, .length = W}, M_PI * R * R * (4.0 / 3 * R + W), 2 * M_PI * R * (2 * R + W), 0, R},
		{"disc", {.kind = SOIL_ELLIPSOID, .size = {R, R, R / 3}}, 4 * M_PI / 9 * R * R * R, oblate_area(R, R / 3), 0, R / 3},
		{"egg", {.kind = SOIL_ELLIPSOID, .size = {3 * R, R, R}}, 4 * M_PI * R * R * R, prolate_area(R, 3 * R), 0, R},
		{"lying disc", {.kind = SOIL_ELLIPSOID, .size = {R, R / 2, R}}, 2 * M_PI / 3 * R * R * R, oblate_area(R, R / 2), 0, R / 2},
	};
	memcpy(list, all, sizeof all);
	return COUNT(all);
}
#define KNOWN 8

static void each_shape_closes_and_has_its_volume(void **state)
{
	struct known list[KNOWN];
	(void)state;
	assert_int_equal(all_known(list), KNOWN);
	for (size_t i = 0; i < KNOWN; i++) {
		const struct known *k = &list[i];
		const struct sums s = sums_for(&k->shape, k->scale / 8);
		print_message("%s: volume %+.4f %%, area %+.4f %%\n", k->name, 100 * (s.volume / k->volume - 1), 100 * (s.area / k->area - 1));
		check_closed(&s, k->volume, 0.005);
		assert_near(s.area, k->area, 0.005 * k->area);
		assert_near(s.by_kind[FACET_SIDE], k->sides, 1e-5 * k->area);
	}
}

/* The error of area, volume and first moments falls with the square of the size or faster; what is exact stays so. */
static void errors_fall_with_the_square_of_the_size(void **state)
{
	struct known list[KNOWN];
	(void)state;
	for (size_t i = 0; i < all_known(list); i++) {
		const struct known *k = &list[i];
		double errors[4];
		for (int j = 0; j < 4; j++) {
			const double share = 0.2 / (1 << j);
			const struct sums s = sums_for(&k->shape, k->scale * share);
			errors[j] = fabs(s.area / k->area - 1) + fabs(s.volume / k->volume - 1);
			for (int a = 0; a < 3; a++)
				errors[j] = support_most(errors[j], fabs(s.tensor[a][a] / k->volume - 1));
			assert_true(errors[j] < 0.1 * share * share + 1e-6);
		}
		print_message("%s: %.2e %.2e %.2e %.2e\n", k->name, errors[0], errors[1], errors[2], errors[3]);
		assert_true(errors[0] < 1e-6 || errors[3] < errors[0] / 40);
	}
}

/* No facet is larger than a square of the size, and a level cut through the middle of a shape has half of its sides. */
static void no_facet_is_larger_than_the_size(void **state)
{
	struct known list[KNOWN];
	(void)state;
	for (size_t i = 0; i < all_known(list); i++) {
		struct soil_facets f = {0};
		const double size = list[i].scale / 9;
		double below = 0;
		assert_ok(soil_facets_of(&list[i].shape, size, &f));
		assert_near(f.size, size, 1e-12);
		assert_false(f.gathered || f.both);
		for (size_t k = 0; k < f.count; k++) {
			assert_true((double)f.area[k] <= size * size * (1 + 1e-5));
			below += (double)f.area[k] * (f.z[k] < 0 ? 1 : f.z[k] > 0 ? 0 : 0.5);
		}
		assert_near(below, sums_of(&f).area / 2, 1e-5 * sums_of(&f).area);
		assert_true(soil_facets_bytes(&f) == f.room * 29);
		soil_facets_finish(&f);
		assert_true(f.count == 0 && f.memory == NULL && soil_facets_bytes(&f) == 0);
	}
}

/* Turns some or all triangles over. */
static void turn_over(struct soil_mesh *mesh, bool all)
{
	for (uint32_t t = 0; t < mesh->triangle_count; t++)
		if (all || any_share() > 0) {
			const uint32_t corner = mesh->triangles[t][1];
			mesh->triangles[t][1] = mesh->triangles[t][2];
			mesh->triangles[t][2] = corner;
		}
}

static void meshes_look_outwards_however_they_are_wound(void **state)
{
	(void)state;
	for (int i = 0; i < 9; i++) {
		struct soil_mesh mesh = i / 3 == 0 ? mesh_block(0.5, 0.3, 0.2) : i / 3 == 1 ? mesh_drum(96, R, W) : mesh_pill(48, 16, R, W);
		const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh};
		const double volume = i / 3 == 0 ? 0.03 : i / 3 == 1 ? M_PI * R * R * W : M_PI * R * R * (4.0 / 3 * R + W);
		if (i % 3 > 0)
			turn_over(&mesh, i % 3 == 1);
		const struct sums s = sums_for(&shape, 0.03);
		check_closed(&s, volume, i / 3 == 2 ? 0.01 : 1e-5);
		if (i / 3 == 0) {
			assert_near(s.by_kind[FACET_SIDE], 0.32, 1e-6);
			assert_near(s.by_kind[FACET_UNDER], 0.3, 1e-6);
		}
		mesh_free(&mesh);
	}
}

/* Gives a mesh vertices of its own for each triangle, so that no edge is shared by number. */
static struct soil_mesh apart(const struct soil_mesh *mesh)
{
	struct soil_mesh own = mesh_with(3 * mesh->triangle_count, mesh->triangle_count);
	for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++) {
		memcpy(own.vertices[i], mesh->vertices[mesh->triangles[i / 3][i % 3]], sizeof *own.vertices);
		own.triangles[i / 3][i % 3] = i;
	}
	mesh_bounds(&own);
	return own;
}

/* A block, one of whose edges has a vertex in its middle that only one of the two sides uses. */
static struct soil_mesh with_a_seam(void)
{
	struct soil_mesh block = mesh_block(0.5, 0.3, 0.2), mesh = mesh_with(9, 13);
	memcpy(mesh.vertices, block.vertices, 8 * sizeof *mesh.vertices);
	memcpy(mesh.triangles, block.triangles, 12 * sizeof *mesh.triangles);
	const uint32_t *last = block.triangles[11];
	for (int k = 0; k < 3; k++)
		mesh.vertices[8][k] = (mesh.vertices[last[1]][k] + mesh.vertices[last[2]][k]) / 2;
	mesh_put(&mesh, 11, last[0], last[1], 8);
	mesh_put(&mesh, 12, last[0], 8, last[2]);
	mesh_bounds(&mesh);
	mesh_free(&block);
	return mesh;
}

/* Two blocks that have one edge in common, with its two vertices. Four triangles meet there. */
static struct soil_mesh two_at_an_edge(void)
{
	struct soil_mesh block = mesh_block(0.2, 0.2, 0.2), mesh = mesh_with(16, 24);
	for (uint32_t i = 0; i < 16; i++)
		for (int k = 0; k < 3; k++)
			mesh.vertices[i][k] = block.vertices[i % 8][k] + (i >= 8 && k < 2 ? 0.2f : 0);
	for (uint32_t t = 0; t < 24; t++)
		for (int k = 0; k < 3; k++)
			mesh.triangles[t][k] = block.triangles[t % 12][k] + (t >= 12 ? 8 : 0);
	mesh_bounds(&mesh);
	mesh_free(&block);
	return mesh;
}

static void seams_do_not_open_a_mesh(void **state)
{
	(void)state;
	for (int i = 0; i < 6; i++) {
		struct soil_mesh block = mesh_block(0.5, 0.3, 0.2);
		struct soil_mesh mesh = i % 3 == 0 ? apart(&block) : i % 3 == 1 ? with_a_seam() : two_at_an_edge();
		const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh};
		if (i >= 3)
			turn_over(&mesh, true);
		const struct sums s = sums_for(&shape, 0.05);
		for (int k = 0; k < 3; k++)
			assert_near(s.vector[k], 0, 1e-6);
		assert_near(s.volume, i % 3 < 2 ? 0.03 : 0.016, 1e-6);
		assert_near(s.area, i % 3 < 2 ? 0.62 : 0.48, 1e-5);
		mesh_free(&block);
		mesh_free(&mesh);
	}
}

/* A sheet, a block without its lid, a pipe without ends, a drum that lacks a part of its rim. */
static struct soil_mesh open_mesh(int kind)
{
	struct soil_mesh mesh = kind < 2 ? mesh_block(0.4, 0.2, 0.1) : mesh_drum(32, R, W);
	if (kind == 0) {
		mesh.triangle_count = 2;
	} else if (kind == 1) {
		memmove(mesh.triangles[2], mesh.triangles[4], 8 * sizeof *mesh.triangles);
		mesh.triangle_count = 10;
	} else if (kind == 2) {
		for (uint32_t t = 0; t < 64; t++)
			memcpy(mesh.triangles[t], mesh.triangles[t / 2 * 4 + t % 2], sizeof *mesh.triangles);
		mesh.triangle_count = 64;
	} else {
		mesh.triangle_count -= 4;
	}
	return mesh;
}

static void open_meshes_look_both_ways(void **state)
{
	static const double areas[] = {0.08, 0.2, 2 * M_PI * R * W, 2 * M_PI * R * (R + W) * 31 / 32};
	(void)state;
	for (int i = 0; i < 12; i++) {
		struct soil_mesh mesh = open_mesh(i % 4);
		const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh};
		struct soil_facets f = {0};
		if (i >= 4)
			turn_over(&mesh, i < 8);
		assert_ok(soil_facets_of(&shape, 0.03, &f));
		check(&f);
		assert_true(f.both && f.count % 2 == 0);
		const struct sums s = sums_of(&f);
		for (int k = 0; k < 3; k++)
			assert_near(s.vector[k], 0, 1e-7);
		assert_near(s.volume, 0, 1e-8);
		assert_near(s.area, 2 * areas[i % 4], i % 4 < 2 ? 1e-6 : 0.004);
		for (size_t k = 0; k < f.count; k += 2)
			for (int a = 0; a < 3; a++) {
				assert_near(place_at(&f, k, a), place_at(&f, k + 1, a), 0);
				assert_near(vector_at(&f, k, a), -vector_at(&f, k + 1, a), 0);
			}
		soil_facets_finish(&f);
		mesh_free(&mesh);
	}
}

/* Triangles without area give no facets, and needles do not give very many. */
static void degenerate_triangles_are_left_out(void **state)
{
	struct soil_mesh mesh = mesh_with(6, 5);
	const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh};
	struct soil_facets f = {0};
	(void)state;
	static const float places[6][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1e-4f, 0}, {0, 0, 0}, {0, 1, 0}};
	memcpy(mesh.vertices, places, sizeof places);
	mesh_put(&mesh, 0, 0, 1, 2); /* on a line */
	mesh_put(&mesh, 1, 0, 0, 1);
	mesh_put(&mesh, 2, 0, 4, 5); /* two vertices in one place */
	mesh_put(&mesh, 3, 3, 3, 3);
	mesh_put(&mesh, 4, 0, 1, 3); /* a needle */
	mesh_bounds(&mesh);
	for (uint32_t count = 4; count <= 5; count++) {
		mesh.triangle_count = count;
		assert_ok(soil_facets_of(&shape, 0.01, &f));
		check(&f);
		assert_near(sums_of(&f).area, count == 4 ? 0 : 1e-4, 1e-8);
		assert_true(count == 4 ? f.count == 0 : f.count >= 200 && f.count <= 204);
	}
	soil_facets_finish(&f);
	mesh_free(&mesh);
}

static void the_number_of_facets_is_bounded(void **state)
{
	struct known list[KNOWN + 2];
	(void)state;
	all_known(list);
	list[KNOWN] = (struct known){.shape = {.kind = SOIL_WHEEL, .radius = 2, .width = 2}, .volume = 8 * M_PI};
	list[KNOWN + 1] = (struct known){.shape = {.kind = SOIL_ELLIPSOID, .size = {1, 1e-3, 0.03}}, .volume = 4e-5 * M_PI};
	for (size_t i = 0; i < KNOWN + 2; i++) {
		static const double sizes[] = {1e-3, 1e-300};
		for (size_t j = 0; j < COUNT(sizes); j++) {
			struct soil_facets f = {0};
			assert_ok(soil_facets_of(&list[i].shape, sizes[j], &f));
			check(&f);
			const struct sums s = sums_of(&f);
			assert_true(f.count > SOIL_FACETS_MOST / 2 && f.size > sizes[j]);
			assert_near(s.volume, list[i].volume, 0.005 * list[i].volume);
			soil_facets_finish(&f);
		}
		/* However large the size, a shape keeps its form. */
		const struct sums coarse = sums_for(&list[i].shape, INFINITY);
		assert_near(coarse.volume, list[i].volume, 0.06 * list[i].volume);
	}
}

/* A mesh of more triangles than there may be facets, and one of many triangles that are not much larger than facets: those that look alike become one. */
static void very_fine_meshes_are_gathered(void **state)
{
	(void)state;
	for (int i = 0; i < 4; i++) {
		const int open = i % 2;
		struct soil_mesh mesh = i < 2 ? mesh_pill(260, 60, R, W) : mesh_pill(96, 24, R, W);
		const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh};
		const double volume = M_PI * R * R * (4.0 / 3 * R + W), area = 2 * M_PI * R * (2 * R + W);
		if (open != 0)
			mesh.triangle_count /= 2;
		for (int j = 0; j < 3; j++) {
			static const double sizes[] = {1e-4, 0.01, 0.05};
			struct soil_facets f = {0};
			assert_ok(soil_facets_of(&shape, sizes[j], &f));
			check(&f);
			const struct sums s = sums_of(&f);
			print_message("size %g: %zu facets, size %.4f, area %+.3f %%\n", sizes[j], f.count, f.size, 100 * (s.area / area - 1));
			assert_true(f.gathered == (i < 2 || j > 0) && f.both == (open != 0));
			assert_true(j == 0 ? f.size > 1e-4 : j == 1 ? f.count < 20000 : f.count < 2000);
			for (int k = 0; k < 3; k++)
				assert_near(s.vector[k], 0, 1e-6);
			assert_near(s.volume, open != 0 ? 0 : volume, 0.01 * volume);
			assert_near(s.area, area, 0.02 * area);
			soil_facets_finish(&f);
		}
		mesh_free(&mesh);
	}
}

static void facets_are_kept_by_what_a_shape_is(void **state)
{
	static struct soil_facets_cache cache;
	struct soil_mesh mesh = mesh_block(0.5, 0.3, 0.2), twin = mesh_block(0.5, 0.3, 0.2);
	struct soil_shape shapes[SOIL_FACETS_KEPT + 1];
	const struct soil_facets *first, *again;
	(void)state;
	for (int i = 0; i <= SOIL_FACETS_KEPT; i++)
		shapes[i] = (struct soil_shape){.kind = SOIL_WHEEL, .radius = 0.1 + 0.01 * i, .width = 0.1};
	shapes[0] = (struct soil_shape){.kind = SOIL_MESH, .mesh = &mesh};
	assert_ok(soil_facets_kept(&cache, &shapes[0], 0.05, &first));
	const size_t bytes = soil_facets_cache_bytes(&cache);
	assert_true(bytes == soil_facets_bytes(first) + 20 * 12);
	shapes[0].mesh = &twin; /* elsewhere in memory, and the same */
	assert_ok(soil_facets_kept(&cache, &shapes[0], 0.05, &again));
	assert_ptr_equal(first, again);
	assert_ok(soil_facets_kept(&cache, &shapes[0], 0.04, &again));
	assert_ptr_not_equal(first, again);
	twin.vertices[0][0] -= 0.01f;
	assert_ok(soil_facets_kept(&cache, &shapes[0], 0.05, &again));
	assert_ptr_not_equal(first, again);
	/* What was asked for last stays longest. */
	const float *const place = again->x;
	for (int i = 1; i < SOIL_FACETS_KEPT; i++) {
		const struct soil_facets *other;
		assert_ok(soil_facets_kept(&cache, &shapes[i], 0.05, &other));
		assert_ptr_not_equal(other, again);
	}
	assert_ptr_equal(again->x, place);
	assert_ok(soil_facets_kept(&cache, &shapes[0], 0.05, &first));
	assert_ptr_equal(first, again);
	assert_true(first->x == place && soil_facets_cache_bytes(&cache) > bytes);
	/* With a belt it has the same facets. */
	shapes[0].belt = true;
	assert_ok(soil_facets_kept(&cache, &shapes[0], 0.05, &again));
	assert_ptr_equal(again->x, place);
	soil_facets_cache_finish(&cache);
	assert_int_equal(soil_facets_cache_bytes(&cache), 0);
	mesh_free(&mesh);
	mesh_free(&twin);
}

/* Each allocation fails in turn: the status says so, nothing is kept, and the next call works. */
static void it_survives_a_lack_of_memory(void **state)
{
	struct soil_mesh meshes[2] = {mesh_block(0.5, 0.3, 0.2), mesh_pill(400, 60, R, W)};
	(void)state;
	for (int i = 0; i < 3; i++) {
		const struct soil_shape shape = {.kind = i == 0 ? SOIL_WHEEL : SOIL_MESH, .radius = R, .width = W, .mesh = i == 0 ? NULL : &meshes[i - 1]};
		uint64_t nth = 0;
		for (bool failed = true; failed;) {
			static struct soil_facets_cache cache;
			const struct soil_facets *out;
			mem_fail_nth(++nth, false);
			const enum status status = soil_facets_kept(&cache, &shape, 0.05, &out);
			failed = mem_fail_nth(0, 0) >= nth;
			assert_int_equal(status, failed ? STATUS_FAILED : STATUS_OK);
			assert_true(failed ? out == NULL && soil_facets_cache_bytes(&cache) == 0 : out->count > 0);
			assert_ok(soil_facets_kept(&cache, &shape, 0.05, &out));
			check(out);
			soil_facets_cache_finish(&cache);
		}
		assert_true(nth > 1 + (i > 0 ? 3 : 0));
	}
	mesh_free(&meshes[0]);
	mesh_free(&meshes[1]);
}

TEST_PROGRAM(facets)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_shape_closes_and_has_its_volume),
		cmocka_unit_test(errors_fall_with_the_square_of_the_size),
		cmocka_unit_test(no_facet_is_larger_than_the_size),
		cmocka_unit_test(meshes_look_outwards_however_they_are_wound),
		cmocka_unit_test(seams_do_not_open_a_mesh),
		cmocka_unit_test(open_meshes_look_both_ways),
		cmocka_unit_test(degenerate_triangles_are_left_out),
		cmocka_unit_test(the_number_of_facets_is_bounded),
		cmocka_unit_test(very_fine_meshes_are_gathered),
		cmocka_unit_test(facets_are_kept_by_what_a_shape_is),
		cmocka_unit_test(it_survives_a_lack_of_memory),
	};
	return cmocka_run_group_tests_name("soil/facets", tests, NULL, NULL);
}
