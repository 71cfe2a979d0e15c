/* The law gives the same bits with every instruction set. The library chooses one as a program starts. So this program has copies of the law, each
 * compiled for one set: meson.build, lanes_names.h. */

#include "bed.h"
#include "meshes.h"
#include "../support/program.h"

#define SIDE 96
#define LAW 6
#define LAW_BITS 0x9ea5f75a7f9e6fcaull /* of `contacts` by that law, on any machine */
#define LAYER_BITS 0x9237d9494d1ae780ull /* and of those with layers, */
#define LOOSE_BITS 0x292f12d5b076a758ull /* with loose and dense soil, */
#define LOOSE_LAYER_BITS 0xbfef85f89cda48adull /* and with both */

static uint32_t word(uint32_t *seed)
{
	*seed = *seed * 1664525u + 1013904223u;
	const uint32_t high = *seed >> 16;
	*seed = *seed * 1664525u + 1013904223u;
	return high << 16 | *seed >> 16;
}

static double share(uint32_t *seed)
{
	return (double)word(seed) / 2147483648.0 - 1;
}

static uint64_t hash_of(uint64_t hash, const void *data, size_t bytes)
{
	for (const unsigned char *at = data, *end = at + bytes; at < end; at++)
		hash = (hash ^ *at) * 1099511628211u;
	return hash;
}

/* A copy of the law. */
struct copy {
	const char *name;
	enum status (*create)(struct soil_work **out);
	void (*destroy)(struct soil_work *work);
	enum status (*press)(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_sink *press,
			     struct soil_work *work, struct soil_imprint *out);
	enum status (*probe)(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work,
			     struct soil_probed *out);
};

#define LANES_COPY(of) \
	enum status of##_work_create(struct soil_work **out); \
	void of##_work_destroy(struct soil_work *work); \
	enum status of##_sink_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_sink *press, \
				    struct soil_work *work, struct soil_imprint *out); \
	enum status of##_probe(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work, \
			       struct soil_probed *out);
#define LANES_ROW(of) {#of, of##_work_create, of##_work_destroy, of##_sink_body, of##_probe}
LANES_COPY(plain)
#ifdef FURROW_LAW_AVX2
LANES_COPY(avx2)
#endif
#ifdef FURROW_LAW_AVX512
LANES_COPY(avx512)
#endif

/* Presses and probes bodies of all forms by a copy of the law, and hashes forces and planes. faces: bodies slide, and soil pushes on their faces. */
static uint64_t contacts(const struct copy *copy, bool layered, bool loosens, bool faces, int *touches)
{
	struct soil_mesh mesh = mesh_pill(24, 6, 0.15, 0.2);
	const struct soil_shape shapes[] = {
		{.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2}, {.kind = SOIL_SPHERE, .radius = 0.2}, {.kind = SOIL_BOX, .size = {0.3, 0.2, 0.2}},
		{.kind = SOIL_CYLINDER, .radius = 0.15, .length = 0.3}, {.kind = SOIL_CAPSULE, .radius = 0.15, .length = 0.3}, {.kind = SOIL_ELLIPSOID, .size = {0.3, 0.2, 0.15}},
		{.kind = SOIL_MESH, .mesh = &mesh}, {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2, .grousers = 18, .grouser_height = 0.02, .grouser_thickness = 0.01},
	};
	static const char *const soils[] = {"dry_sand", "lunar", "heavy_clay_25"};
	uint64_t hash = 14695981039346656037u;
	struct soil_work *work;
	uint32_t seed = 1;
	assert_ok(copy->create(&work));
	for (int round = 0; round < 48; round++) {
		const struct soil_shape *shape = &shapes[round % 8];
		const struct soil_numbers soil = bed_soil(soils[round / 8 % 3]);
		struct bed bed;
		bed_init(&bed, &soil, round % 4 == 0 ? 0.0137 : 0.021, SIDE, 0.1 * share(&seed), 0.1 * share(&seed));
		bed.law.faces = faces;
		bed.law.inertia = 1;
		struct soil_numbers below = bed_soil(soils[(round / 8 + 1) % 3]);
		if (round % 2 == 1)
			soil_set_rigid(&below);
		bed.law.soils[0].over = layered ? &below : NULL;
		bed.law.soils[0].thickness = 0.05;
		soil_law_set_layers(&bed.law);
		if (loosens)
			bed_loosen(&bed, 0.67, round % 3 == 1 ? 0.8 : 0);
		bed.law.bulldozing = 0.5;
		bed.law.slip_sinkage = round % 3 == 0 ? 0.5 : 0;
		bed.law.ground_normals = round % 5 == 4;
		for (size_t i = 0; i < bed.posts; i++)
			bed.planes.base[i] += word(&seed) % 97 == 0 ? BASE_NODATA - bed.planes.base[i] : (int32_t)(word(&seed) % 800);
		const double middle = SIDE / 2 * bed.law.spacing, heading = 3 * share(&seed);
		struct bed_state now = bed_state(middle, middle, bed_ground(&bed, middle, middle) + soil_shape_reach(shape, 0.2 * (round % 2), 0.1) - 0.01, heading,
						 0.2 * (round % 2), 0.1);
		for (int i = 0; i < 8; i++) {
			const struct bed_state before = now;
			const double rotated[3] = {0.01 * share(&seed), 0.05 * share(&seed), 0.01 * share(&seed)};
			now.at[0] += 0.01 * cos(heading) + 0.001 * share(&seed);
			now.at[1] += 0.01 * sin(heading);
			now.at[2] -= 0.002 * share(&seed);
			struct soil_motion motion = bed_motion(shape, &before, &now, rotated);
			motion.linear[0] = 0.2 * share(&seed);
			motion.angular[1] = share(&seed);
			motion.load = i % 3 == 2 ? 600 : 0;
			motion.stamped = 0.5;
			if (faces)
				motion.trend = (struct soil_trend){.whole = {.way = {cos(heading), sin(heading), 0}, .turn = {0, 0, share(&seed)}}, .last = {.way = {cos(heading), sin(heading), 0}}};
			if (loosens && i % 3 == 2)
				bed_fill(&bed, 0.004);
			const struct soil_laying laying = soil_laying_of(shape, &motion.from, &motion.to, motion.turned, motion.rotated, bed.law.spacing);
			const struct soil_sink press = {.laying = &laying, .soils = bed.laid, .start = -100};
			struct soil_probed probed;
			struct soil_imprint pressed;
			assert_ok(copy->probe(&bed.law, &bed.planes, &motion, work, &probed));
			assert_ok(copy->press(&bed.law, &bed.planes, &motion, &press, work, &pressed));
			assert_true(probed.known);
			*touches += pressed.forces.force[2] > 0;
			hash = hash_of(hash, &probed.force, sizeof probed.force + sizeof probed.moment + sizeof probed.stiffness + sizeof probed.damping);
			hash = hash_of(hash, &pressed.forces.force, sizeof pressed.forces.force + sizeof pressed.forces.moment);
			hash = hash_of(hash, &pressed.raised, sizeof pressed.raised);
		}
		const int32_t *const planes[] = {bed.planes.offset, bed.planes.deposited, bed.planes.sinkage, bed.planes.shear, bed.planes.dug,
						 bed.planes.settled, bed.planes.loose, bed.planes.floor, bed.planes.density};
		for (size_t k = 0; k < COUNT(planes) && planes[k] != NULL; k++)
			hash = hash_of(hash, planes[k], bed.posts * sizeof(int32_t));
		bed_finish(&bed);
	}
	mesh_free(&mesh);
	copy->destroy(work);
	return hash;
}

static bool can_run(const char *set)
{
#if defined FURROW_LAW_AVX2 || defined FURROW_LAW_AVX512
	if (strcmp(set, "avx2") == 0)
		return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
	if (strcmp(set, "avx512") == 0)
		return __builtin_cpu_supports("x86-64-v4");
#endif
	return true;
}

static void all_instruction_sets_give_the_same_bits(void **state)
{
	static const struct copy chosen = {"chosen", soil_work_create, soil_work_destroy, soil_sink_body, soil_probe};
	static const struct copy copies[] = {
		LANES_ROW(plain),
#ifdef FURROW_LAW_AVX2
		LANES_ROW(avx2),
#endif
#ifdef FURROW_LAW_AVX512
		LANES_ROW(avx512),
#endif
	};
	static const uint64_t pinned[] = {LAW_BITS, LAYER_BITS, LOOSE_BITS, LOOSE_LAYER_BITS};
	int touches = 0;
	uint64_t wanted[COUNT(pinned)];
	for (size_t k = 0; k < COUNT(pinned); k++) {
		const int before = touches;
		wanted[k] = contacts(&chosen, k % 2 == 1, k / 2 == 1, false, &touches);
		print_message("the library: hash %zu %llx of %d touches\n", k, (unsigned long long)wanted[k], touches - before);
		assert_true(touches - before > 200);
	}
	/* If this fails, the law gives other bits than before. Then raise SOIL_LAW, so that no drive goes on by another law than it began with. */
	assert_int_equal(SOIL_LAW, LAW);
	assert_memory_equal(wanted, pinned, sizeof wanted);
	const uint64_t with_faces = contacts(&chosen, false, false, true, &touches);
	assert_true(with_faces != wanted[0]);
	for (size_t i = 0; i < COUNT(copies); i++) {
		if (!can_run(copies[i].name)) {
			print_message("%s: not on this processor\n", copies[i].name);
			continue;
		}
		assert_true(contacts(&copies[i], false, false, true, &touches) == with_faces);
		for (size_t k = 0; k < COUNT(pinned); k++) {
			const uint64_t got = contacts(&copies[i], k % 2 == 1, k / 2 == 1, false, &touches);
			print_message("%s: hash %zu %llx\n", copies[i].name, k, (unsigned long long)got);
			assert_true(got == wanted[k]);
		}
	}
}

TEST_PROGRAM(lanes)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(all_instruction_sets_give_the_same_bits)};
	return cmocka_run_group_tests_name("soil/lanes", tests, NULL, NULL);
}
