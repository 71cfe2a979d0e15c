/*
 * The prefetcher over insets: no step reads base tiles of any level, where without it many do; and
 * how far insets reach.
 */
#include "../long.h"
#include "../support.h"

#include "insets.h"
#include "../support/program.h"
#include "motion/motion.h"
#include "resident/inset_areas.h"
#include "resident/prefetcher.h"

#define POST 0.125
#define DT 0.05
#define END 60.0

/* Over the outer inset and its hole, along and across the inner one and its rims, beside both. */
static const double ways[][6][2] = {
        {{10, 10}, {90, 75}, {76, 72}, {66, 88}, {58, 82}, {200, 100}},
        {{74, 60}, {74.5, 100}, {93.3, 79.4}, {94.5, 69}, {70, 70}, {92, 78}},
        {{39.5, 30}, {39.5, 150}, {104.5, 121}, {105, 47}, {30, 47.5}, {250, 190}},
};

struct trip {
	uint64_t waits, reads, sum;
};

/* Drives all ways at once. prefetch: s; 0: nothing is prefetched. */
static struct trip travel(const char *path, uint32_t tiles, double prefetch, double speed)
{
	enum { WAYS = sizeof ways / sizeof *ways };
	struct scene_waypoint points[6] = {{0}};
	struct store *store;
	struct ground *ground;
	struct prefetcher *prefetcher = NULL;
	struct track *tracks[WAYS];
	int64_t next[WAYS] = {0};
	struct trip trip = {0, 0, 0};
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(resident_ground_create(store, tiles, &ground));
	for (int i = 0; i < WAYS; i++) {
		for (int k = 0; k < 6; k++) {
			points[k].x = ways[i][k][0];
			points[k].y = ways[i][k][1];
		}
		must(motion_track_create(&(struct scene_path){.count = 6, .speed = speed, .points = points}, POST, 1, &tracks[i]));
	}
	struct look_ahead_body bodies[WAYS];
	for (int i = 0; i < WAYS; i++)
		bodies[i] = (struct look_ahead_body){.path = motion_track_ahead(tracks[i])};
	const struct look_ahead_params params = {
	        .store = store,
	        .ground = ground,
	        .tiles = tiles - tiles / 4,
	        .bodies = bodies,
	        .count = WAYS,
	        .spacing = POST,
	        .prefetch = prefetch,
	        .end = END,
	};
	if (prefetch > 0) {
		must(resident_prefetcher_create(&params, &prefetcher));
		resident_prefetcher_wait(prefetcher);
	}
	for (int64_t step = 1; (double)step * DT <= END; step++) {
		for (int i = 0; i < WAYS; i++)
			for (; next[i] < motion_track_samples(tracks[i]); next[i]++) {
				struct track_point point;
				int64_t height;
				bool any;
				if (motion_track_sample_time(tracks[i], next[i]) >
				    (double)step * DT)
					break;
				motion_track_sample(tracks[i], next[i], &point);
				must(resident_ground_height(ground, point.qx, point.qy, &height,
				                            &any));
				trip.sum = trip.sum * 31 + (any ? (uint64_t)height : 1);
			}
		if (prefetcher == NULL)
			continue;
		resident_prefetcher_tell(prefetcher, (double)step * DT);
		resident_prefetcher_wait(prefetcher);
	}
	resident_prefetcher_destroy(prefetcher);
	struct resident_ground_figures figures;
	resident_ground_figures(ground, &figures);
	trip.waits = figures.waits;
	trip.reads = figures.reads;
	for (int i = 0; i < WAYS; i++)
		motion_track_destroy(tracks[i]);
	resident_ground_destroy(ground);
	store_close(store);
	return trip;
}

static void no_step_reads_the_base_of_an_inset(void **state)
{
	static const uint32_t cells[] = {8, 16, 64};
	static const double prefetches[] = {0.2, 1.5, 100}, speeds[] = {3, 10, 40};
	for (int told = 0; told < 2; told++)
		for (int i = 0; i < 3; i++) {
			if (!long_or_part((size_t)told, (size_t)i, 2))
				continue;
			insets_told = told ? INSETS_TEXT : NULL;
			const char *path = insets_store(cells[i]);
			for (int k = 0; k < 3; k++) {
				struct trip alone = travel(path, 64, 0, speeds[k]),
				            led = travel(path, 64, prefetches[k], speeds[k]);
				print_message("%u cells, %g m/s, %g s: %llu waits of %llu reads; "
				              "led %llu of %llu\n",
				              cells[i], speeds[k], prefetches[k],
				              (unsigned long long)alone.waits,
				              (unsigned long long)alone.reads,
				              (unsigned long long)led.waits,
				              (unsigned long long)led.reads);
				assert_true(alone.waits > 5);
				assert_int_equal(led.waits, 0);
				assert_true(led.sum == alone.sum);
			}
		}
}

/* Of every place and level: where a tile is stored within reach, the level found is as fine. */
static void no_tile_is_out_of_reach(void **state)
{
	static const uint32_t cells[] = {8, 16, 64};
	for (int i = 0; i < 3; i++) {
		struct store *store;
		struct store_reader *reader;
		struct inset_areas insets, whole;
		int coarse = 0;
		insets_told = INSETS_TEXT;
		must(store_open(insets_store(cells[i]), &(struct store_options){.mode = STORE_READ},
		                &store));
		must(store_reader_create(store, &reader));
		must(resident_inset_areas_init(store, &insets));
		assert_int_equal(insets.count, 2);
		const struct extent *extent = &store_meta(store)->extent;
		for (double y = 0; y <= 48; y += 0.37)
			for (double x = 0; x <= 64; x += 0.41)
				for (double reach = 0; reach <= 2; reach++) {
					int level = resident_inset_areas_level(&insets, x, y, reach);
					coarse += level == 0;
					for (int finer = INSETS_FINEST; finer < level; finer++)
						for (int corner = 0; corner < 4; corner++) {
							double px =
							        fmin(fmax(x + (corner % 2 ? reach
							                                  : -reach),
							                  0),
							             64);
							double py =
							        fmin(fmax(y + (corner / 2 ? reach
							                                  : -reach),
							                  0),
							             48);
							struct store_range range;
							bool found;
							must(store_find_base_range(
							        reader,
							        resident_ground_tile_of(
							                extent, finer, px, py),
							        &range, &found));
							assert_false(found);
						}
				}
		assert_true(coarse > (cells[i] < 64 ? 100 : -1));
		resident_inset_areas_finish(&insets);
		store_reader_destroy(reader);
		store_close(store);
		/* Without a word of where they are, they may be anywhere. */
		insets_told = NULL;
		must(store_open(insets_store(cells[i]), &(struct store_options){.mode = STORE_READ},
		                &store));
		must(resident_inset_areas_init(store, &whole));
		assert_int_equal(resident_inset_areas_level(&whole, 0, 0, 0), INSETS_FINEST);
		assert_int_equal(resident_inset_areas_level(&whole, 64, 48, 0), INSETS_FINEST);
		resident_inset_areas_finish(&whole);
		store_close(store);
	}
}

TEST_PROGRAM(inset_areas)
{
	const struct CMUnitTest tests[] = {
	        cmocka_unit_test(no_step_reads_the_base_of_an_inset),
	        cmocka_unit_test(no_tile_is_out_of_reach),
	};
	return cmocka_run_group_tests_name("insets", tests, support_enter, support_leave);
}
