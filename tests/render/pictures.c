/* Whole drives that are watched: with slots for all the pictures are the same however tiles come;
 * with few they are coarser, and the ground is not. */
#include "../support.h"
#include "../support/program.h"

static const struct extent extent = {513, 513, 1, 32};

static const char scene_text[] =
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 4\n"
	"spacing: 0.5\n"
	"redistribute: {model: box}\n"
	"attributes: [dirt]\n"
	"objects:\n"
	"  - {name: a, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[40, 60], [200, 240]], speed: 40}}\n"
	"view:\n"
	"  size: [320, 180]\n"
	"  camera: {chase: a, back: 14, up: 9}\n"
	"  effects: [texture, sky, geomorph, skirts]\n"
	"  images: 10\n";

static char *watch(const char *store, const char *const *settings)
{
	const char *scene = support_path("scene.yaml");
	support_write(scene, scene_text);
	support_store(store, extent, support_hills);
	return support_drive(scene, store, settings);
}

static size_t read_picture(int step, unsigned char *bytes, size_t room)
{
	char name[64];
	snprintf(name, sizeof name, "out/frame-%06d.png", step);
	FILE *file = fopen(support_path(name), "rb");
	assert_non_null(file);
	size_t size = fread(bytes, 1, room, file);
	fclose(file);
	assert_true(size > 1000 && size < room);
	return size;
}

static void the_same_pictures_whatever_loads_the_tiles(void **state)
{
	enum { ROOM = 1 << 18, PICTURES = 4 };
	static unsigned char first[PICTURES][ROOM], again[ROOM];
	size_t sizes[PICTURES];
	const char *const settings[][4] = {
		{"cache.slots=512", "cache.loaders=1", "cache.prefetch=0", NULL},
		{"cache.slots=512", "cache.loaders=3", "cache.prefetch=2", NULL},
		{"cache.slots=700", "cache.loaders=2", "cache.prefetch=0.3", NULL},
		{"cache.slots=512", "cache.loaders=0", NULL},
	};
	for (int run = 0; run < 4; run++) {
		char *json = watch(support_path("same.furrow"), settings[run]);
		assert_int_equal(support_figure(json, "\"view\"", "coarsened"), 0);
		assert_int_equal(support_figure(json, "\"view\"", "frames"), PICTURES);
		mem_free(json);
		for (int i = 0; i < PICTURES; i++) {
			if (run == 0) {
				sizes[i] = read_picture(10 * (i + 1), first[i], ROOM);
				continue;
			}
			assert_int_equal(read_picture(10 * (i + 1), again, ROOM), sizes[i]);
			assert_memory_equal(again, first[i], sizes[i]);
		}
	}
	assert_true(sizes[0] != sizes[1] || memcmp(first[0], first[1], sizes[0]) != 0);
}

static void few_slots_coarsen_the_picture_and_leave_the_ground_alone(void **state)
{
	const char *few = support_path("few.furrow"), *all = support_path("all.furrow");
	mem_free(watch(all, (const char *[]){"cache.slots=512", NULL}));
	const char *const slots[] = {"cache.slots=4", "cache.slots=12"};
	for (int i = 0; i < 2; i++) {
		/* Every frame is a picture that is kept: it has all that its slots can hold. */
		char *json = watch(few, (const char *[]){slots[i], "view.images=1", NULL});
		long long frames = support_figure(json, "\"view\"", "frames");
		assert_int_equal(frames, 40);
		assert_int_equal(support_figure(json, "\"view\"", "coarsened"), frames);
		assert_int_equal(support_figure(json, "\"view\"", "starved"), frames);
		mem_free(json);
		support_verify(few);
		assert_true(support_hash(few) == support_hash(all));
	}
}

TEST_PROGRAM(pictures)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_same_pictures_whatever_loads_the_tiles),
		cmocka_unit_test(few_slots_coarsen_the_picture_and_leave_the_ground_alone),
	};
	return cmocka_run_group_tests_name("pictures", tests, support_enter, support_leave);
}
